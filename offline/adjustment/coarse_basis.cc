#include "adjustment/coarse_basis.h"

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <numeric>

namespace raygrid {
namespace {

// Returns the board index of each point: points observed with a common pose
// share a board.
std::vector<int> FindBoardIndices(const std::vector<ViewJacobian>& jacobians,
                                  int num_points) {
  std::vector<int> parent(num_points);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&parent](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const ViewJacobian& jacobian : jacobians)
    for (const int point : jacobian.points)
      parent[root(point)] = root(jacobian.points.front());
  std::vector<int> board(num_points);
  for (int i = 0; i < num_points; ++i) board[i] = root(i);
  return board;
}

// Quadratic polynomials along the two longest principal axes of the points,
// normalized to magnitudes of about 1.
constexpr int kNumQuadraticTerms = 6;
Eigen::MatrixXd EvaluateQuadratics(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Matrix3Xd centered(3, points.size());
  for (size_t i = 0; i < points.size(); ++i) centered.col(i) = points[i];
  centered.colwise() -= Eigen::Vector3d(centered.rowwise().mean());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(
      centered * centered.transpose() / static_cast<double>(points.size()));
  const double scale = 1 / std::sqrt(axes.eigenvalues()[2] + 1e-30);
  const Eigen::ArrayXd x =
      scale * (axes.eigenvectors().col(2).transpose() * centered).array();
  const Eigen::ArrayXd y =
      scale * (axes.eigenvectors().col(1).transpose() * centered).array();
  Eigen::MatrixXd quadratics(points.size(), kNumQuadraticTerms);
  quadratics << Eigen::ArrayXd::Ones(x.size()), x, y, x * x, x * y, y * y;
  return quadratics;
}

}  // namespace

CoarseBasis MakeCoarseBasis(const ParameterLayout& layout,
                            const std::vector<GridShape>& shapes,
                            const std::vector<ViewJacobian>& jacobians,
                            const std::vector<Eigen::Vector3d>& points) {
  std::vector<Eigen::Triplet<double>> triplets;
  int num_columns = 0;
  for (size_t c = 0; c < shapes.size(); ++c) {
    const int first = layout.first_camera[c];
    const GridShape& fine = shapes[c];
    if (fine.per_node > 0) {
      GridShape coarse = fine;
      while (std::max(coarse.columns, coarse.rows) - 3 > kCoarsestCells)
        coarse = coarse.Halved();
      const GridTransfer transfer(fine, coarse);
      for (int node = 0; node < fine.num_nodes(); ++node) {
        const auto& x = transfer.columns()[node % fine.columns];
        const auto& y = transfer.rows()[node / fine.columns];
        for (int k = 0; k < 16; ++k) {
          const double weight = y.weight[k / 4] * x.weight[k % 4];
          const int coarse_node =
              (y.first + k / 4) * coarse.columns + x.first + k % 4;
          for (int p = 0; weight != 0 && p < fine.per_node; ++p)
            triplets.emplace_back(first + node * fine.per_node + p,
                                  num_columns + coarse_node * fine.per_node + p,
                                  weight);
        }
      }
      num_columns += coarse.num_parameters();
    }
    for (int i = fine.num_parameters();
         i < layout.NumCameraParameters(static_cast<int>(c)); ++i)
      triplets.emplace_back(first + i, num_columns++, 1);
  }
  for (int i = layout.first_camera.back(); i < layout.first_point; ++i)
    triplets.emplace_back(i, num_columns++, 1);
  if (layout.num_points > 0) {
    const std::vector<int> board =
        FindBoardIndices(jacobians, layout.num_points);
    for (int b = 0; b < layout.num_points; ++b) {
      std::vector<int> members;
      std::vector<Eigen::Vector3d> board_points;
      for (int i = 0; board[b] == b && i < layout.num_points; ++i) {
        if (board[i] != b) continue;
        members.push_back(i);
        board_points.push_back(points[i]);
      }
      if (members.size() < kNumQuadraticTerms) continue;
      const Eigen::MatrixXd quadratics = EvaluateQuadratics(board_points);
      for (size_t i = 0; i < members.size(); ++i)
        for (int k = 0; k < 3 * kNumQuadraticTerms; ++k)
          triplets.emplace_back(layout.Point(members[i]) + k % 3,
                                num_columns + k, quadratics(i, k / 3));
      num_columns += 3 * kNumQuadraticTerms;
    }
  }
  Eigen::SparseMatrix<double, Eigen::RowMajor> basis(layout.size, num_columns);
  basis.setFromTriplets(triplets.begin(), triplets.end());
  return basis;
}

}  // namespace raygrid
