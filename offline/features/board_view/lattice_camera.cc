#include "features/board_view/lattice_camera.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

using LensParameters = LatticeCamera::Parameters;

enum {
  kFocal,
  kK1,
  kK2,
  kCenterX,
  kCenterY,
  kRotation,
  kTranslation = kRotation + 3,
  kNumParameters = kTranslation + 3
};

static_assert(std::tuple_size_v<LensParameters> == kNumParameters);

// Transforms a board position (in squares) to camera coordinates.
template <typename T>
std::array<T, 3> PointAt(const T* p, const Eigen::Vector2d& place) {
  const T on_board[3] = {T(place.x()), T(place.y()), T(0)};
  std::array<T, 3> point;
  ceres::AngleAxisRotatePoint(p + kRotation, on_board, point.data());
  for (int k = 0; k < 3; ++k) point[k] += p[kTranslation + k];
  return point;
}

template <typename T>
Eigen::Matrix<T, 2, 1> ProjectPoint(const T* p, const Eigen::Vector2d& place) {
  const std::array<T, 3> point = PointAt(p, place);
  using std::atan2;
  using std::sqrt;
  const T across2 = point[0] * point[0] + point[1] * point[1];
  constexpr double kOnTheAxis = 1e-20;
  if (across2 < kOnTheAxis) return {p[kCenterX], p[kCenterY]};
  const T across = sqrt(across2), angle = atan2(across, point[2]);
  const T angle2 = angle * angle;
  const T radius_px =
      p[kFocal] * angle * (1.0 + angle2 * (p[kK1] + angle2 * p[kK2]));
  return {p[kCenterX] + radius_px * point[0] / across,
          p[kCenterY] + radius_px * point[1] / across};
}

struct ReprojectionError {
  template <typename T>
  bool operator()(const T* parameters, T* error) const {
    const Eigen::Matrix<T, 2, 1> seen = ProjectPoint(parameters, place);
    error[0] = seen.x() - pixel.x();
    error[1] = seen.y() - pixel.y();
    return true;
  }

  Eigen::Vector2d place, pixel;
};

std::vector<ReprojectionError> SelectEvenly(
    const std::vector<Feature>& features) {
  constexpr size_t kMaxCount = 100;
  const size_t step = (features.size() + kMaxCount - 1) / kMaxCount;
  std::vector<ReprojectionError> chosen;
  for (size_t i = 0; i < features.size(); i += step)
    chosen.push_back({Eigen::Vector2d(features[i].column, features[i].row),
                      features[i].pixel});
  return chosen;
}

// Estimates the board's pose for an equidistant projection with this focal
// length: a homography maps board positions to rays.
std::optional<LensParameters> Start(
    const std::vector<ReprojectionError>& errors, const ImageSize& size,
    double focal_px) {
  LensParameters start = {focal_px, 0, 0, (size.width - 1) / 2.0,
                          (size.height - 1) / 2.0};
  const Eigen::Vector2d center(start[kCenterX], start[kCenterY]);
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  std::vector<Eigen::Vector3d> rays;
  for (const ReprojectionError& e : errors) {
    const Eigen::Vector2d offset = e.pixel - center;
    const double angle = offset.norm() / focal_px;
    if (angle >= M_PI) return std::nullopt;
    Eigen::Vector3d ray(0, 0, std::cos(angle));
    ray.head<2>() = std::sin(angle) * offset.normalized();
    rays.push_back(ray);
    Eigen::Matrix3d cross;  // ray x
    cross << 0, -ray.z(), ray.y(), ray.z(), 0, -ray.x(), -ray.y(), ray.x(), 0;
    Eigen::Matrix<double, 3, 9> rows;
    rows << e.place.x() * cross, e.place.y() * cross, cross;
    normal.noalias() += rows.transpose() * rows;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(
      normal);
  Eigen::Matrix3d homography =
      Eigen::Map<const Eigen::Matrix3d>(solver.eigenvectors().col(0).data());
  double forwards = 0;
  for (size_t i = 0; i < errors.size(); ++i)
    forwards += rays[i].dot(homography * errors[i].place.homogeneous());
  homography *= (forwards < 0 ? -2 : 2) /
                (homography.col(0).norm() + homography.col(1).norm());
  Eigen::Matrix3d axes = homography;
  axes.col(2) = axes.col(0).cross(axes.col(1));
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      axes, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::AngleAxisd rotation(
      Eigen::Matrix3d(svd.matrixU() * svd.matrixV().transpose()));
  const Eigen::Vector3d turn = rotation.angle() * rotation.axis();
  std::copy_n(turn.data(), 3, start.begin() + kRotation);
  std::copy_n(homography.col(2).data(), 3, start.begin() + kTranslation);
  return start;
}

double AngleRad(const LensParameters& parameters,
                const Eigen::Vector2d& place) {
  const std::array<double, 3> point = PointAt(parameters.data(), place);
  return std::atan2(std::hypot(point[0], point[1]), point[2]);
}

// Returns the maximum angle at which the model is used: 1.2 times the maximum
// angle of the features, but only while the slope of the radial projection is
// above 0.2 times the focal length.
double MaxAngleRad(const std::vector<ReprojectionError>& errors,
                   const LensParameters& parameters) {
  constexpr double kFarther = 1.2, kMinSlope = 0.2, kStepRad = 0.01;
  double widest = 0;
  for (const ReprojectionError& e : errors)
    widest = std::max(widest, AngleRad(parameters, e.place));
  double angle = 0;
  while (
      angle < kFarther * widest &&
      1 + angle * angle *
                  (3 * parameters[kK1] + 5 * parameters[kK2] * angle * angle) >
          kMinSlope)
    angle += kStepRad;
  return angle;
}

double ComputeMedianErrorPx(const std::vector<ReprojectionError>& errors,
                            const LensParameters& parameters) {
  std::vector<double> lengths;
  for (const ReprojectionError& e : errors)
    lengths.push_back(
        (ProjectPoint(parameters.data(), e.place) - e.pixel).norm());
  const auto median = lengths.begin() + lengths.size() / 2;
  std::nth_element(lengths.begin(), median, lengths.end());
  return *median;
}

void OptimizeCameras(const std::vector<ReprojectionError>& errors,
                     LensParameters* parameters) {
  constexpr double kLossScalePx = 1;
  ceres::Problem problem;
  for (const ReprojectionError& e : errors)
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<ReprojectionError, 2, kNumParameters>(
            new ReprojectionError(e)),
        new ceres::CauchyLoss(kLossScalePx), parameters->data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 50;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
}

}  // namespace

std::optional<LatticeCamera> LatticeCamera::Fit(
    const std::vector<Feature>& features, const ImageSize& size) {
  constexpr size_t kMinFeatures = 20;
  constexpr double kMaxMedianPx = 1;
  if (features.size() < kMinFeatures) return std::nullopt;
  const auto errors = SelectEvenly(features);
  std::optional<LensParameters> best;
  double least_px = INFINITY;
  for (const double half_width_rad : {0.3, 0.6, 0.9, 1.2, 1.5, 1.8}) {
    const auto start = Start(errors, size, size.width / 2.0 / half_width_rad);
    if (!start) continue;
    const double median_px = ComputeMedianErrorPx(errors, *start);
    if (!(median_px < least_px)) continue;
    best = start;
    least_px = median_px;
  }
  if (!best) return std::nullopt;
  OptimizeCameras(errors, &*best);
  if (!(ComputeMedianErrorPx(errors, *best) < kMaxMedianPx))
    return std::nullopt;
  return LatticeCamera(*best, MaxAngleRad(errors, *best));
}

std::optional<Eigen::Vector2d> LatticeCamera::Project(
    const Eigen::Vector2d& place) const {
  if (AngleRad(parameters_, place) > max_angle_rad_) return std::nullopt;
  return ProjectPoint(parameters_.data(), place);
}

std::optional<std::vector<Correspondence>> LatticeCamera::Sample(
    const Eigen::Vector2d& place, double reach) const {
  constexpr int kSteps = 2;
  std::vector<Correspondence> samples;
  for (int row = -kSteps; row <= kSteps; ++row) {
    for (int column = -kSteps; column <= kSteps; ++column) {
      const Eigen::Vector2d offset =
          reach / kSteps * Eigen::Vector2d(column, row);
      const auto pixel = Project(place + offset);
      if (!pixel) return std::nullopt;
      samples.push_back({offset, *pixel});
    }
  }
  return samples;
}

std::optional<LocalMapping> LatticeCamera::Around(
    const Eigen::Vector2d& place) const {
  constexpr int kDegree = 3;
  for (const double reach : {1.0, 0.5}) {
    const auto around = Sample(place, reach);
    LocalMapping mapping;
    if (!around || FitLocalMapping(*around, kDegree, &mapping) == 0) continue;
    mapping.center = ProjectPoint(parameters_.data(), place);
    return mapping;
  }
  return std::nullopt;
}

}  // namespace raygrid
