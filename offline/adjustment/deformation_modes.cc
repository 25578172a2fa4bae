#include "adjustment/deformation_modes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

namespace raygrid {
namespace {

constexpr int kMinOrder = 2, kMaxOrder = 4;

// Coordinate frame of a board: its centre, the two axes of its plane, and its
// normal.
struct Plane {
  Eigen::Vector3d center;
  Eigen::Matrix3d axes;  // columns; the normal is last
  bool is_flat = false;
};

Plane FitBoardPlane(const std::vector<Eigen::Vector3d>& points) {
  constexpr double kMaxFlatExtentRatio = 0.02;  // fraction of the board's width
  Eigen::Matrix3Xd centered(3, points.size());
  for (size_t i = 0; i < points.size(); ++i)
    centered.col(static_cast<Eigen::Index>(i)) = points[i];
  Plane plane;
  plane.center = centered.rowwise().mean();
  centered.colwise() -= plane.center;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      centered * centered.transpose());
  plane.axes = solver.eigenvectors().rowwise().reverse();
  const Eigen::Vector3d extents = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  plane.is_flat = extents[0] <= kMaxFlatExtentRatio * extents[1];
  return plane;
}

// Returns the coordinates of the points in the plane, from -1 to 1 over the
// board.
Eigen::Matrix2Xd PlaneCoordinates(const Plane& plane,
                                  const std::vector<Eigen::Vector3d>& points) {
  Eigen::Matrix2Xd coordinates(2, points.size());
  for (size_t i = 0; i < points.size(); ++i)
    coordinates.col(static_cast<Eigen::Index>(i)) =
        plane.axes.leftCols<2>().transpose() * (points[i] - plane.center);
  return coordinates;
}

double SquaredRadius(const Plane& plane,
                     const std::vector<Eigen::Vector3d>& points) {
  return PlaneCoordinates(plane, points).squaredNorm() /
         static_cast<double>(points.size());
}

Eigen::ArrayXd Legendre(int order, const Eigen::ArrayXd& x) {
  Eigen::ArrayXd before = Eigen::ArrayXd::Ones(x.size()), value = x;
  if (order == 0) return before;
  for (int n = 1; n < order; ++n) {
    const Eigen::ArrayXd next =
        ((2 * n + 1) * x * value - n * before) / (n + 1);
    before = value;
    value = next;
  }
  return value;
}

// Orthogonalizes a height field against the previous modes, and normalizes it
// to a mean square of 1. Returns false if the points cannot distinguish it from
// them.
bool AddOrthogonal(const Eigen::VectorXd& height,
                   std::vector<Eigen::VectorXd>* heights) {
  constexpr double kMinIndependentFraction = 1e-3;
  const double count = static_cast<double>(height.size());
  Eigen::VectorXd rest = height;
  for (int pass = 0; pass < 2; ++pass)  // twice for numerical accuracy
    for (const Eigen::VectorXd& other : *heights)
      rest -= other.dot(rest) / count * other;
  if (!(rest.norm() > kMinIndependentFraction * height.norm())) return false;
  heights->push_back(rest * std::sqrt(count) / rest.norm());
  return true;
}

void AddDeformation(const BoardPoints& board, const Plane& plane,
                    DeformationModes* modes) {
  const Eigen::Matrix2Xd places = PlaneCoordinates(plane, board.nominal);
  const Eigen::Array2d extent =
      places.rowwise().maxCoeff().cwiseMax(-places.rowwise().minCoeff());
  const Eigen::ArrayXd x = places.row(0).transpose().array() / extent.x();
  const Eigen::ArrayXd y = places.row(1).transpose().array() / extent.y();
  std::vector<Eigen::VectorXd> heights;
  int mode = 0;
  for (int order = 0; order <= kMaxOrder; ++order)
    for (int i = 0; i <= order; ++i) {
      const bool is_observed = AddOrthogonal(
          (Legendre(order - i, x) * Legendre(i, y)).matrix(), &heights);
      if (order < kMinOrder) continue;
      for (Eigen::Index p = 0; is_observed && p < x.size(); ++p)
        modes->by_point[board.first + p].col(mode) =
            heights.back()[p] * plane.axes.col(2);
      ++mode;
    }
}

}  // namespace

int DeformationModes::num_boards() const {
  if (boards.empty()) return 0;
  return *std::max_element(boards.begin(), boards.end()) + 1;
}

void DeformationModes::Remove(DeformationOrder order,
                              std::vector<Coefficients>* coefficients) {
  for (int mode = count() - 1; mode >= 0; --mode) {
    if (orders[mode] != order) continue;
    orders.erase(orders.begin() + mode);
    const int behind = count() - mode;
    for (Displacement& displacement : by_point) {
      displacement.middleCols(mode, behind) =
          displacement.rightCols(behind).eval();
      displacement.conservativeResize(Eigen::NoChange, count());
    }
    for (Coefficients& f : *coefficients) {
      f.segment(mode, behind) = f.tail(behind).eval();
      f.conservativeResize(count());
    }
  }
}

double DeformationModes::MaxStdDevM() const {
  constexpr double kMaxRelativeStdDev = 0.02;
  return kMaxRelativeStdDev * board_radius_m;
}

DeformationModes MakeDeformationModes(const std::vector<BoardPoints>& boards,
                                      int num_points) {
  constexpr size_t kMinPoints = 8;
  DeformationModes modes;
  for (int order = kMinOrder; order <= kMaxOrder; ++order)
    modes.orders.insert(modes.orders.end(), order + 1,
                        static_cast<DeformationOrder>(order - kMinOrder));
  modes.by_point.assign(num_points,
                        DeformationModes::Displacement::Zero(3, modes.count()));
  double squared_radii = 0;
  int num_boards = 0;
  modes.boards.assign(num_points, 0);
  for (size_t b = 0; b < boards.size(); ++b) {
    const BoardPoints& board = boards[b];
    std::fill_n(modes.boards.begin() + board.first, board.nominal.size(),
                static_cast<int>(b));
    if (board.nominal.size() < kMinPoints) continue;
    const Plane plane = FitBoardPlane(board.nominal);
    if (!plane.is_flat) continue;
    AddDeformation(board, plane, &modes);
    squared_radii += SquaredRadius(plane, board.nominal);
    ++num_boards;
  }
  if (num_boards == 0) return {};
  modes.board_radius_m = std::sqrt(squared_radii / num_boards);
  return modes;
}

}  // namespace raygrid
