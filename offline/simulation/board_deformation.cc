#include "simulation/board_deformation.h"

#include <array>
#include <cmath>

namespace raygrid {
namespace {

constexpr int kMinOrder = 2, kMaxOrder = 4;

// Legendre polynomials, normalized to a mean square of 1 over [-1, 1].
std::array<double, kMaxOrder + 1> Legendre(double x) {
  std::array<double, kMaxOrder + 1> values = {1, x};
  for (int n = 1; n < kMaxOrder; ++n)
    values[n + 1] = ((2 * n + 1) * x * values[n] - n * values[n - 1]) / (n + 1);
  for (int n = 0; n <= kMaxOrder; ++n) values[n] *= std::sqrt(2 * n + 1);
  return values;
}

}  // namespace

Board DeformBoard(const Board& board, double rms_m, Random* random) {
  if (rms_m == 0) return board;
  // Coefficients of the height: [order in x][order in y].
  double height[kMaxOrder + 1][kMaxOrder + 1] = {};
  double variance = 0;
  for (int order = kMinOrder; order <= kMaxOrder; ++order)
    for (int i = 0; i <= order; ++i) {
      const double deviation = 1.0 / (order * order);
      height[i][order - i] = deviation * random->Normal();
      variance += deviation * deviation;
    }
  // The last feature is diagonally opposite the first, which is the origin.
  const Eigen::Vector2d half = board.NominalPoints().back().head<2>() / 2;
  Board deformed_board = board;
  for (Eigen::Vector3d& point : deformed_board.points) {
    const auto legendre_x = Legendre(point.x() / half.x() - 1);
    const auto legendre_y = Legendre(point.y() / half.y() - 1);
    double sum = 0;
    for (int i = 0; i <= kMaxOrder; ++i)
      for (int j = 0; i + j <= kMaxOrder; ++j)
        sum += height[i][j] * legendre_x[i] * legendre_y[j];
    point.z() += rms_m / std::sqrt(variance) * sum;
  }
  return deformed_board;
}

}  // namespace raygrid
