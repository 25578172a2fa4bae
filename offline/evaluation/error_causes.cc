#include "evaluation/error_causes.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

constexpr int kViewBlocks = 4;

Eigen::Index GetColumn(size_t feature) {
  return 2 * static_cast<Eigen::Index>(feature);
}

// Assigns consecutive images to one half, since they are similar.
std::vector<int> AssignHalvesByView(const BudgetInput& input) {
  const int num_views = static_cast<int>(CountFeaturesByView(input).size());
  std::vector<int> half;
  for (const BudgetFeature& feature : input.features)
    half.push_back(feature.view * kViewBlocks / num_views % 2);
  return half;
}

// Splits the features into halves by blocks of the lattice: neighbouring
// features share errors of unmodelled causes, which blocks mostly keep within
// one half.
std::vector<int> AssignHalvesByBlock(const BudgetInput& input) {
  constexpr int kBlocksAlongBoard = 6;
  int columns = 1, rows = 1;
  for (const BudgetFeature& feature : input.features) {
    columns = std::max(columns, feature.column + 1);
    rows = std::max(rows, feature.row + 1);
  }
  const int width =
      std::max(1, static_cast<int>(std::lround(double(std::min(columns, rows)) /
                                               kBlocksAlongBoard)));
  std::vector<int> half;
  for (const BudgetFeature& feature : input.features)
    half.push_back((feature.column / width + feature.row / width) % 2);
  return half;
}

// Returns the cell size for about 16 features per cell.
double CellPx(const BudgetInput& input) {
  constexpr double kFeaturesInCell = 16, kMinCellPx = 16, kMinCells = 6;
  Area area = {1e9, 1e9, -1e9, -1e9};
  for (const BudgetFeature& feature : input.features)
    area.Extend(feature.pixel);
  const double width = std::max(area.width(), 1.0);
  const double height = std::max(area.height(), 1.0);
  const double knot_spacing_px =
      std::sqrt(width * height * kFeaturesInCell /
                static_cast<double>(input.features.size()));
  return std::clamp(knot_spacing_px, kMinCellPx,
                    std::max(kMinCellPx, std::max(width, height) / kMinCells));
}

// Centre and axes of a board.
struct BoardPlane {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
};

std::vector<BoardPlane> FitBoardPlanes(const BudgetInput& input) {
  int num_boards = 0;
  for (const int board : input.boards)
    num_boards = std::max(num_boards, board + 1);
  std::vector<Eigen::Vector3d> sums(num_boards, Eigen::Vector3d::Zero());
  std::vector<Eigen::Matrix3d> squares(num_boards, Eigen::Matrix3d::Zero());
  std::vector<int> counts(num_boards, 0);
  for (size_t p = 0; p < input.points.size(); ++p) {
    if (!input.points[p].allFinite()) continue;
    const int b = input.boards[p];
    sums[b] += input.points[p];
    squares[b] += input.points[p] * input.points[p].transpose();
    ++counts[b];
  }
  std::vector<BoardPlane> planes(num_boards);
  for (int b = 0; b < num_boards; ++b) {
    if (counts[b] == 0) continue;
    planes[b].center = sums[b] / counts[b];
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
        squares[b] -
        counts[b] * planes[b].center * planes[b].center.transpose());
    planes[b].x = solver.eigenvectors().col(2);
    planes[b].y = solver.eigenvectors().col(1);
  }
  return planes;
}

// Returns the Jacobian of a point with respect to stretches along both axes of
// its board and to a shear.
Eigen::Matrix3d ComputeStretches(const BoardPlane& plane,
                                 const Eigen::Vector3d& point) {
  const double x = plane.x.dot(point - plane.center);
  const double y = plane.y.dot(point - plane.center);
  Eigen::Matrix3d moves;
  moves << x * plane.x, y * plane.y, y * plane.x + x * plane.y;
  return moves;
}

// Returns the projected position of a feature relative to the image centre. A
// column of observed positions contains the noise, and would fit it after the
// pose is eliminated.
Eigen::Vector2d ProjectOffsetFromCenter(const BudgetInput& input,
                                        const BudgetFeature& feature) {
  return feature.pixel + feature.error_px -
         Eigen::Vector2d(input.image_size.width - 1,
                         input.image_size.height - 1) /
             2;
}

// Returns the Jacobian of a feature with respect to the coefficients of a
// per-view cause.
Eigen::Matrix2Xd ApplyJacobian(ErrorCause cause, const BudgetInput& input,
                               const std::vector<BoardPlane>& planes,
                               const BudgetFeature& feature) {
  const double width = input.image_size.width, height = input.image_size.height;
  const Eigen::Vector2d from_center = ProjectOffsetFromCenter(input, feature);
  switch (cause) {
    case ErrorCause::kDeformation:
      return feature.J_point * input.bends[feature.point];
    case ErrorCause::kInPlane:
      return feature.J_point *
             ComputeStretches(planes[input.boards[feature.point]],
                              input.points[feature.point]);
    case ErrorCause::kImageAffine: {
      Eigen::Matrix<double, 2, 3> errors;
      errors << from_center / width, Eigen::Matrix2d::Identity();
      return errors;
    }
    default:  // rolling shutter
      return feature.J_pose * (from_center.y() / height);
  }
}

// Scales each row to an RMS of 1.
void ScaleRows(Eigen::MatrixXd* columns) {
  const double count = static_cast<double>(columns->cols());
  for (Eigen::Index k = 0; k < columns->rows(); ++k) {
    const double rms = columns->row(k).norm() / std::sqrt(count);
    if (rms > 0) columns->row(k) /= rms;
  }
}

// Makes the model of a per-view cause from the Jacobian of each feature.
template <typename Errors>
LinearCauseModel MakePerViewCauseModel(const BudgetInput& input,
                                       const PoseComponents& pose,
                                       const Errors& errors_of) {
  const std::vector<int> counts = CountFeaturesByView(input);
  LinearCauseModel linear;
  linear.half = AssignHalvesByBlock(input);
  linear.num_units = static_cast<int>(counts.size());
  for (size_t i = 0; i < input.features.size(); ++i) {
    const BudgetFeature& feature = input.features[i];
    const Eigen::Matrix2Xd errors = errors_of(feature);
    if (i == 0) linear.columns.resize(errors.cols(), 2 * input.features.size());
    linear.columns.middleCols<2>(GetColumn(i)) = errors.transpose();
    linear.unit.push_back(
        counts[feature.view] >= kMinBudgetViewFeatures ? feature.view : -1);
  }
  ScaleRows(&linear.columns);
  pose.RemoveFromRows(&linear.columns);
  return linear;
}

}  // namespace

std::vector<int> CountFeaturesByView(const BudgetInput& input) {
  std::vector<int> counts;
  for (const BudgetFeature& feature : input.features) {
    if (static_cast<size_t>(feature.view) >= counts.size())
      counts.resize(feature.view + 1, 0);
    ++counts[feature.view];
  }
  return counts;
}

PoseComponents::PoseComponents(const BudgetInput& input) {
  size_t first = 0;
  for (const int count : CountFeaturesByView(input)) {
    if (count == 0) continue;
    Eigen::MatrixXd J_pose(2 * count, 6);
    for (int i = 0; i < count; ++i)
      J_pose.middleRows<2>(2 * i) = input.features[first + i].J_pose;
    for (Eigen::Index k = 0; k < 6; ++k)
      if (J_pose.col(k).norm() > 0) J_pose.col(k).normalize();
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(J_pose);
    qr.setThreshold(1e-9);
    views_.push_back(
        {GetColumn(first),
         qr.householderQ() * Eigen::MatrixXd::Identity(2 * count, qr.rank())});
    first += count;
  }
}

void PoseComponents::Remove(Eigen::VectorXd* errors) const {
  for (const ViewTerms& view : views_) {
    auto own = errors->segment(view.first, view.basis.rows());
    const Eigen::VectorXd part = view.basis.transpose() * own;
    own.noalias() -= view.basis * part;
  }
}

void PoseComponents::RemoveFromRows(Eigen::MatrixXd* columns) const {
  for (const ViewTerms& view : views_) {
    auto own = columns->middleCols(view.first, view.basis.rows());
    const Eigen::MatrixXd part = own * view.basis;
    own.noalias() -= part * view.basis.transpose();
  }
}

LinearCauseModel MakeImagePositionCauseModel(const BudgetInput& input) {
  LinearCauseModel cause;
  cause.half = AssignHalvesByView(input);
  const double knot_spacing_px = CellPx(input);
  const int columns =
      static_cast<int>(std::ceil(input.image_size.width / knot_spacing_px)) + 1;
  const int rows =
      static_cast<int>(std::ceil(input.image_size.height / knot_spacing_px)) +
      1;
  cause.num_units = columns * rows;
  const auto get_cell = [knot_spacing_px](double position, int count) {
    return std::clamp(static_cast<int>(position / knot_spacing_px), 0,
                      count - 1);
  };
  cause.columns.resize(2, 2 * input.features.size());
  for (size_t i = 0; i < input.features.size(); ++i) {
    const Eigen::Vector2d& pixel = input.features[i].pixel;
    cause.unit.push_back(get_cell(pixel.y(), rows) * columns +
                         get_cell(pixel.x(), columns));
    cause.columns.middleCols<2>(GetColumn(i)).setIdentity();
  }
  return cause;
}

LinearCauseModel MakeBoardPositionCauseModel(const BudgetInput& input) {
  LinearCauseModel cause;
  cause.half = AssignHalvesByView(input);
  cause.num_units = static_cast<int>(input.points.size());
  cause.columns.resize(3, 2 * input.features.size());
  for (size_t i = 0; i < input.features.size(); ++i) {
    cause.unit.push_back(input.features[i].point);
    cause.columns.middleCols<2>(GetColumn(i)) =
        input.features[i].J_point.transpose();
  }
  return cause;
}

std::optional<LinearCauseModel> MakeViewCauseModel(ErrorCause cause,
                                                   const BudgetInput& input,
                                                   const PoseComponents& pose) {
  const bool is_deformation = cause == ErrorCause::kDeformation;
  if (is_deformation &&
      (input.bends.empty() || input.bends.front().cols() == 0))
    return std::nullopt;
  const std::vector<BoardPlane> planes = FitBoardPlanes(input);
  return MakePerViewCauseModel(input, pose, [&](const BudgetFeature& feature) {
    return ApplyJacobian(cause, input, planes, feature);
  });
}

LinearCauseModel MakeColumnDelayControl(const BudgetInput& input,
                                        const PoseComponents& pose) {
  const double width = input.image_size.width;
  return MakePerViewCauseModel(
      input, pose, [&](const BudgetFeature& feature) -> Eigen::Matrix2Xd {
        return feature.J_pose *
               (ProjectOffsetFromCenter(input, feature).x() / width);
      });
}

}  // namespace raygrid
