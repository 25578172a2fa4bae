#include "calibration/camera_check.h"

#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "adjustment/reprojection_error.h"
#include "calibration/calibration_problem.h"
#include "calibration/near_duplicates.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

// Returns the focal length at the centre of the calibrated area: pixels per
// radian of rotation.
double FocalPx(const CameraModel& camera) {
  constexpr double kStepPx = 2;
  const Eigen::Vector2d center = camera.area().center();
  const auto left = camera.Unproject(center - Eigen::Vector2d(kStepPx, 0));
  const auto right = camera.Unproject(center + Eigen::Vector2d(kStepPx, 0));
  if (!left || !right)
    throw InputError("the camera model is undefined at the centre of its area");
  return 2 * kStepPx / std::acos(std::min(1.0, left->dot(*right)));
}

bool HasUncertainty(const CameraFile& file) {
  return file.training && file.uncertainty &&
         !file.uncertainty->modes.displacements_px.empty();
}

ReferenceCamera MakeReferenceCamera(const CameraFile& file) {
  if (!HasUncertainty(file))
    throw InputError(
        "the camera file has no uncertainty; use a camera.yaml written by this "
        "version of raygrid calibrate");
  ReferenceCamera known;
  known.size = file.camera->image_size();
  known.area = file.camera->area();
  known.focal_px = FocalPx(*file.camera);
  known.noise_px = file.training->rms_px / std::sqrt(2);
  known.modes = file.uncertainty->modes;
  return known;
}

ProjectedView ProjectFeatures(const CameraModel& camera, const Pose& pose,
                              const CalibrationProblem& problem, int view,
                              const Pattern& pattern) {
  ProjectedView projected;
  for (const Observation& observation : problem.views[view].observations) {
    const Eigen::Vector3d rotated =
        pose.rotation * problem.nominal[observation.point];
    LinearizedProjection linear;
    if (!camera.area().Contains(observation.pixel) ||
        !camera.Linearize(rotated + pose.translation, &observation.pixel,
                          kAdjustmentMarginPx, &linear))
      continue;
    Eigen::Matrix<double, 3, 6> J_update;  // update as in UpdatedPose()
    J_update << 0, rotated.z(), -rotated.y(), 1, 0, 0,  //
        -rotated.z(), 0, rotated.x(), 0, 1, 0,          //
        rotated.y(), -rotated.x(), 0, 0, 0, 1;
    const Feature feature = problem.GetFeature(pattern, view, observation);
    projected.push_back({observation.pixel, observation.pixel - linear.pixel,
                         linear.J_point * J_update, feature.column,
                         feature.row});
  }
  return projected;
}

using FeatureIdentity = std::tuple<std::string, int, int, int>;

// Held-out prediction errors by feature.
using PredictionErrors = std::map<FeatureIdentity, Eigen::Vector2d>;

Dataset MakeFeatureDataset(const std::vector<FeatureResidual>& residuals,
                           const ImageSize& size, PredictionErrors* errors) {
  Dataset dataset;
  dataset.image_size = size;
  for (const FeatureResidual& r : residuals) {
    if (dataset.images.empty() || dataset.images.back().image != r.image)
      dataset.images.push_back({r.image, {}});
    dataset.images.back().features.push_back(
        {r.board, r.column, r.row, r.pixel});
    (*errors)[{r.image, r.board, r.column, r.row}] = r.error_px;
  }
  return dataset;
}

}  // namespace

CameraCheck CheckCamera(const CameraFile& file, const Dataset& dataset,
                        const Pattern& pattern, int num_threads) {
  // Different photographs of the same view differ by more than this due to
  // noise.
  constexpr double kCopyPx = 0.01;
  const ReferenceCamera known = MakeReferenceCamera(file);
  CameraCheck check;
  const std::vector<NearDuplicates> copies =
      FindNearDuplicates({dataset}, {}, kCopyPx);
  for (const NearDuplicates& group : copies)
    for (const std::string& copy : group.others)
      check.rejected_images.push_back({copy, "duplicate of " + group.image});
  const CalibrationProblem problem = BuildProblem(
      {RemoveDuplicates(dataset, copies)}, pattern, &check.rejected_images);
  const std::vector<std::optional<Pose>> poses =
      LocalizeViews(*file.camera, 0, problem, num_threads);
  std::vector<ProjectedView> views;
  std::set<std::string> images;
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const std::string& image = problem.images[v];
    ProjectedView view;
    if (poses[v])
      view = ProjectFeatures(*file.camera, *poses[v], problem, v, pattern);
    if (view.size() < kMinViewFeatures) {
      check.rejected_images.push_back({image, "pose estimation failed"});
      continue;
    }
    views.push_back(std::move(view));
    images.insert(image);
  }
  if (views.empty())
    throw Error(ExitCode::kInsufficientData,
                "no pose could be estimated; check that features and pattern "
                "belong to this camera");
  check.num_images = static_cast<int>(images.size());
  check.change = TestCameraChange(known, views);
  return check;
}

MovementErrors EstimateExcessErrors(
    const CameraFile& file, const std::vector<FeatureResidual>& held_out,
    double training_share, const Pattern& pattern, int num_threads) {
  constexpr size_t kTypicalNumImages =
      5;                            // typical number of images for `check`
  constexpr size_t kMinImages = 8;  // minimum for a standard deviation
  PredictionErrors errors;
  const Dataset dataset =
      MakeFeatureDataset(held_out, file.camera->image_size(), &errors);
  if (!HasUncertainty(file) || dataset.images.size() < kMinImages) return {};
  ReferenceCamera known = MakeReferenceCamera(file);
  for (auto& mode : known.modes.displacements_px)
    for (Eigen::Vector2d& displacement : mode)
      displacement /= std::sqrt(training_share);
  known.modes.residual_px /= std::sqrt(training_share);
  std::vector<RejectedImage> ignored;
  const CalibrationProblem problem = BuildProblem({dataset}, pattern, &ignored);
  const std::vector<std::optional<Pose>> poses =
      LocalizeViews(*file.camera, 0, problem, num_threads);
  std::vector<std::vector<ProjectedView>> groups;
  std::set<std::string> images;
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    if (!poses[v]) continue;
    ProjectedView view =
        ProjectFeatures(*file.camera, *poses[v], problem, v, pattern);
    if (view.size() < kMinViewFeatures) continue;
    const int board = pattern.boards[problem.boards[v]].id;
    for (ProjectedFeature& feature : view)
      feature.error_px =
          -errors.at({problem.images[v], board, feature.column, feature.row});
    const bool is_new = images.insert(problem.images[v]).second;
    if (groups.empty() || (is_new && images.size() % kTypicalNumImages == 1))
      groups.emplace_back();
    groups.back().push_back(std::move(view));
  }
  return ComputeExcessErrors(known, groups);
}

}  // namespace raygrid
