#include "initialization/pixelwise_model.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "dataset/parallel_for.h"
#include "initialization/median.h"

namespace raygrid {
namespace {

constexpr size_t kMinRays = 30;
constexpr size_t kMaxRays = 300;  // per pose
constexpr double kMinRaysInFront = 0.9;
constexpr double kOutlierAngles = 6;
constexpr int kHomographyRounds = 3;
constexpr int kPoseIterations = 15;
// Minimum fractions of a view's pixels with known directions, in order of
// preference.
constexpr double kMinOverlapFractions[] = {0.7, 0.5, 0.3};
constexpr int kAveragingRounds = 3;
// Maximum error of views that are consistent with the existing directions.
constexpr double kMaxErrorPx = 8;

Eigen::Vector3d ComputeRay(const Pose& pose, const Eigen::Vector2d& point) {
  return (pose * Eigen::Vector3d(point.x(), point.y(), 0)).normalized();
}

std::vector<double> AngleErrors(const std::vector<PointRayMatch>& matches,
                                const Pose& pose) {
  std::vector<double> errors;
  for (const PointRayMatch& match : matches)
    errors.push_back((ComputeRay(pose, match.point) - match.ray).norm());
  return errors;
}

// Homography from homogeneous board points to rays. Points are normalized to
// the observed region of the board.
struct BoardHomography {
  Eigen::Vector2d centroid;
  double unit_m = 1;
  Eigen::Matrix3d rays_from_board;

  Eigen::Vector3d Apply(const Eigen::Vector2d& point) const {
    return rays_from_board *
           Eigen::Vector2d((point - centroid) / unit_m).homogeneous();
  }
};

// Minimizes the algebraic error of ray x (H point) = 0.
void FitRays(const std::vector<PointRayMatch>& matches,
             const std::vector<bool>& use, BoardHomography* homography) {
  using Matrix9 = Eigen::Matrix<double, 9, 9>;
  Matrix9 normal = Matrix9::Zero();
  for (size_t i = 0; i < matches.size(); ++i) {
    if (!use[i]) continue;
    const Eigen::Vector2d scaled =
        (matches[i].point - homography->centroid) / homography->unit_m;
    const Eigen::Vector3d point = scaled.homogeneous();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() -
                                   matches[i].ray * matches[i].ray.transpose();
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        normal.block<3, 3>(3 * a, 3 * b) += point[a] * point[b] * across;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix9> eigen(normal);
  const Eigen::Matrix<double, 9, 1> h = eigen.eigenvectors().col(0);
  homography->rays_from_board = Eigen::Map<const Eigen::Matrix3d>(h.data());
  // The board's z axis points away from the camera, which is in front of the
  // board.
  if (homography->rays_from_board.determinant() < 0)
    homography->rays_from_board *= -1;
}

std::optional<BoardHomography> FitRaysRobustly(
    const std::vector<PointRayMatch>& matches) {
  BoardHomography homography;
  const double count = static_cast<double>(matches.size());
  homography.centroid.setZero();
  for (const PointRayMatch& match : matches)
    homography.centroid += match.point / count;
  double sum = 0;
  for (const PointRayMatch& match : matches)
    sum += (match.point - homography.centroid).squaredNorm();
  homography.unit_m = std::sqrt(sum / (2 * count));
  if (!(homography.unit_m > 0)) return std::nullopt;

  std::vector<bool> use(matches.size(), true);
  for (int round = 0; round < kHomographyRounds; ++round) {
    FitRays(matches, use, &homography);
    if (!homography.rays_from_board.allFinite()) return std::nullopt;
    std::vector<double> errors;
    for (const PointRayMatch& match : matches)
      errors.push_back(
          (homography.Apply(match.point).normalized() - match.ray).norm());
    const double limit = kOutlierAngles * Median(errors) + 1e-12;
    for (size_t i = 0; i < matches.size(); ++i) use[i] = errors[i] <= limit;
  }
  const auto ahead = std::count_if(
      matches.begin(), matches.end(), [&](const PointRayMatch& match) {
        return homography.Apply(match.point).dot(match.ray) > 0;
      });
  if (static_cast<double>(ahead) < kMinRaysInFront * count) return std::nullopt;
  return homography;
}

Pose ComputePose(const BoardHomography& homography) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(
      homography.rays_from_board.leftCols<2>(),
      Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::Matrix<double, 3, 2> axes =
      svd.matrixU() * svd.matrixV().transpose();
  Eigen::Matrix3d rotation;
  rotation << axes, axes.col(0).cross(axes.col(1));
  Pose pose;
  pose.rotation = Eigen::Quaterniond(rotation).normalized();
  const Eigen::Vector3d centroid(homography.centroid.x(),
                                 homography.centroid.y(), 0);
  pose.translation = homography.rays_from_board.col(2) * homography.unit_m /
                         svd.singularValues().mean() -
                     pose.rotation * centroid;
  return pose;
}

// Returns the sum of the Cauchy losses of the angular errors.
double RobustCost(const std::vector<PointRayMatch>& matches, const Pose& pose,
                  double scale) {
  double cost = 0;
  for (const double error : AngleErrors(matches, pose))
    cost += std::log1p(error * error / (scale * scale));
  return cost;
}

// Refines a pose by iteratively reweighted Levenberg-Marquardt steps.
Pose RefinePose(const std::vector<PointRayMatch>& matches, const Pose& start) {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  const double scale = 3 * Median(AngleErrors(matches, start)) + 1e-12;
  Pose pose = start;
  double cost = RobustCost(matches, pose, scale);
  double damping = 1e-4;
  for (int iteration = 0; iteration < kPoseIterations; ++iteration) {
    Matrix6 normal = Matrix6::Zero();
    Vector6 right = Vector6::Zero();
    for (const PointRayMatch& match : matches) {
      const Eigen::Vector3d rotated =
          pose.rotation * Eigen::Vector3d(match.point.x(), match.point.y(), 0);
      const Eigen::Vector3d moved = rotated + pose.translation;
      const double length = moved.norm();
      const Eigen::Vector3d ray = moved / length;
      const Eigen::Matrix3d J_moved =
          (Eigen::Matrix3d::Identity() - ray * ray.transpose()) / length;
      Eigen::Matrix3d minus_cross;
      minus_cross << 0, rotated.z(), -rotated.y(), -rotated.z(), 0, rotated.x(),
          rotated.y(), -rotated.x(), 0;
      Eigen::Matrix<double, 3, 6> jacobian;
      jacobian << J_moved * minus_cross, J_moved;
      const Eigen::Vector3d error = ray - match.ray;
      const double weight = 1 / (1 + error.squaredNorm() / (scale * scale));
      normal += weight * jacobian.transpose() * jacobian;
      right -= weight * jacobian.transpose() * error;
    }
    Matrix6 damped = normal;
    damped.diagonal() *= 1 + damping;
    const Vector6 update = damped.ldlt().solve(right);
    if (!update.allFinite()) break;
    const Pose next = UpdatedPose(pose, update);
    const double next_cost = RobustCost(matches, next, scale);
    if (next_cost < cost) {
      const bool converged = cost - next_cost < 1e-9 * cost;
      pose = next;
      cost = next_cost;
      damping /= 10;
      if (converged) break;
    } else {
      damping *= 10;
    }
  }
  return pose;
}

// Returns the matches of a view at pixels with known directions.
std::vector<PointRayMatch> MatchesWithDirections(const DenseView& view,
                                                 const PixelwiseModel& model) {
  std::vector<PointRayMatch> matches;
  for (const DenseMatch& match : view.matches)
    if (model.directions[match.pixel])
      matches.push_back({match.point, *model.directions[match.pixel]});
  return matches;
}

std::vector<PointRayMatch> Subsample(const std::vector<PointRayMatch>& all) {
  const size_t count = std::min(all.size(), kMaxRays);
  std::vector<PointRayMatch> some;
  for (size_t i = 0; i < count; ++i)
    some.push_back(all[i * all.size() / count]);
  return some;
}

// Returns the typical angle between adjacent lattice pixels.
double TypicalRadiansPerPixel(const PixelLattice& lattice,
                              const PixelwiseModel& model) {
  std::vector<double> angles;
  for (int i = 0; i + 1 < lattice.size(); ++i) {
    const auto& here = model.directions[i];
    const auto& next = model.directions[i + 1];
    if ((i + 1) % lattice.columns != 0 && here && next)
      angles.push_back((*here - *next).norm() / lattice.step_px);
  }
  return Median(angles);
}

// Averages the directions over all views with poses.
void AverageDirections(const std::vector<DenseView>& views,
                       const PixelLattice& lattice, PixelwiseModel* model) {
  std::vector<Eigen::Vector3d> sums(lattice.size(), Eigen::Vector3d::Zero());
  for (size_t v = 0; v < views.size(); ++v) {
    if (!model->camera_from_board[v]) continue;
    for (const DenseMatch& match : views[v].matches)
      sums[match.pixel] +=
          ComputeRay(*model->camera_from_board[v], match.point);
  }
  for (int i = 0; i < lattice.size(); ++i) {
    model->directions[i].reset();
    if (sums[i].norm() > 0) model->directions[i] = sums[i].normalized();
  }
  model->radians_per_px = TypicalRadiansPerPixel(lattice, *model);
}

// Estimates the poses of the given views; nullopt for views that fail.
std::vector<std::optional<Pose>> LocalizeViewsByOverlap(
    const std::vector<DenseView>& views, const PixelwiseModel& model,
    const std::vector<int>& which, int num_threads) {
  std::vector<std::optional<Pose>> poses(which.size());
  ParallelFor(static_cast<int>(which.size()), num_threads, [&](int i) {
    const auto localized = LocalizeOnRays(
        Subsample(MatchesWithDirections(views[which[i]], model)));
    if (localized &&
        localized->median_error_rad < kMaxErrorPx * model.radians_per_px)
      poses[i] = localized->camera_from_board;
  });
  return poses;
}

// Adds the views whose fraction of pixels with known directions is sufficient.
// Returns false if no pose can be estimated.
bool AddViews(const std::vector<DenseView>& views, const PixelLattice& lattice,
              double min_overlap_fraction, int num_threads,
              PixelwiseModel* model) {
  std::vector<int> candidates;
  for (size_t v = 0; v < views.size(); ++v) {
    if (model->camera_from_board[v]) continue;
    const size_t count = MatchesWithDirections(views[v], *model).size();
    if (count >= kMinRays &&
        static_cast<double>(count) >=
            min_overlap_fraction * static_cast<double>(views[v].matches.size()))
      candidates.push_back(static_cast<int>(v));
  }
  const auto poses =
      LocalizeViewsByOverlap(views, *model, candidates, num_threads);
  bool added = false;
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (!poses[i]) continue;
    model->camera_from_board[candidates[i]] = poses[i];
    added = true;
  }
  if (added) AverageDirections(views, lattice, model);
  return added;
}

void RelocalizeViews(const std::vector<DenseView>& views,
                     const PixelLattice& lattice, int num_threads,
                     PixelwiseModel* model) {
  std::vector<int> all;
  for (size_t v = 0; v < views.size(); ++v) all.push_back(static_cast<int>(v));
  model->camera_from_board =
      LocalizeViewsByOverlap(views, *model, all, num_threads);
  AverageDirections(views, lattice, model);
}

double MedianAnglePx(const std::vector<DenseView>& views,
                     const PixelwiseModel& model) {
  std::vector<double> errors;
  for (size_t v = 0; v < views.size(); ++v)
    if (model.camera_from_board[v])
      for (const double error :
           AngleErrors(MatchesWithDirections(views[v], model),
                       *model.camera_from_board[v]))
        errors.push_back(error);
  return Median(errors) / model.radians_per_px;
}

}  // namespace

std::optional<LocalizedBoard> LocalizeOnRays(
    const std::vector<PointRayMatch>& matches) {
  if (matches.size() < kMinRays) return std::nullopt;
  const auto homography = FitRaysRobustly(matches);
  if (!homography) return std::nullopt;
  LocalizedBoard localized;
  localized.camera_from_board = RefinePose(matches, ComputePose(*homography));
  localized.median_error_rad =
      Median(AngleErrors(matches, localized.camera_from_board));
  return localized;
}

int PixelwiseModel::num_localized() const {
  return static_cast<int>(
      std::count_if(camera_from_board.begin(), camera_from_board.end(),
                    [](const auto& pose) { return pose.has_value(); }));
}

PixelwiseModel GrowPixelwiseModel(const std::vector<DenseView>& views,
                                  const PixelLattice& lattice,
                                  const SolvedTriplet& triplet,
                                  int num_threads) {
  PixelwiseModel model;
  model.directions.resize(lattice.size());
  model.camera_from_board.resize(views.size());
  for (int k = 0; k < 3; ++k)
    model.camera_from_board[triplet.views[k]] =
        triplet.poses.CameraFromBoard(k);
  AverageDirections(views, lattice, &model);
  for (const double part : kMinOverlapFractions) {
    while (AddViews(views, lattice, part, num_threads, &model)) {
    }
  }
  for (int round = 0; round < kAveragingRounds; ++round)
    RelocalizeViews(views, lattice, num_threads, &model);
  model.median_error_px = MedianAnglePx(views, model);
  return model;
}

}  // namespace raygrid
