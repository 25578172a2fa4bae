#include "calibration/camera_check.h"

#include <cmath>
#include <set>

#include "adjustment/reprojection_error.h"
#include "calibration/calibration_problem.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

// Pixels by which the middle of the area moves for a radian.
double FocalPx(const CameraModel& camera) {
  constexpr double kStepPx = 2;
  const Eigen::Vector2d middle = camera.area().center();
  const auto left = camera.Unproject(middle - Eigen::Vector2d(kStepPx, 0));
  const auto right = camera.Unproject(middle + Eigen::Vector2d(kStepPx, 0));
  if (!left || !right)
    throw InputError("the camera does not tell the middle of its area");
  return 2 * kStepPx / std::acos(std::min(1.0, left->dot(*right)));
}

KnownCamera Known(const CameraFile& file) {
  if (!file.training || !file.uncertainty ||
      file.uncertainty->modes.displacements_px.empty())
    throw InputError(
        "the camera file does not say how well the camera is known; check "
        "needs a camera.yaml that this version of calibrate wrote");
  KnownCamera known;
  known.size = file.camera->image_size();
  known.area = file.camera->area();
  known.focal_px = FocalPx(*file.camera);
  known.noise_px = file.training->rms_px / std::sqrt(2);
  known.modes = file.uncertainty->modes;
  return known;
}

PlacedView Place(const CameraModel& camera, const Pose& pose,
                 const CalibrationProblem& problem, int view,
                 const Pattern& pattern) {
  PlacedView placed;
  for (const Observation& observation : problem.views[view].observations) {
    const Eigen::Vector3d turned =
        pose.rotation * problem.nominal[observation.point];
    LinearizedProjection linear;
    if (!camera.area().Contains(observation.pixel) ||
        !camera.Linearize(turned + pose.translation, &observation.pixel,
                          kAdjustmentMarginPx, &linear))
      continue;
    Eigen::Matrix<double, 3, 6> by_update;  // as UpdatedPose() has it
    by_update << 0, turned.z(), -turned.y(), 1, 0, 0,  //
        -turned.z(), 0, turned.x(), 0, 1, 0,           //
        turned.y(), -turned.x(), 0, 0, 0, 1;
    const Feature feature = problem.FeatureOf(pattern, view, observation);
    placed.push_back({observation.pixel, observation.pixel - linear.pixel,
                      linear.by_point * by_update, feature.column,
                      feature.row});
  }
  return placed;
}

}  // namespace

CameraCheck CheckCamera(const CameraFile& file, const Dataset& dataset,
                        const Pattern& pattern, int num_threads) {
  const KnownCamera known = Known(file);
  CameraCheck check;
  const CalibrationProblem problem =
      BuildProblem({dataset}, pattern, &check.rejected_images);
  const std::vector<std::optional<Pose>> poses =
      LocalizeViews(*file.camera, 0, problem, num_threads);
  std::vector<PlacedView> views;
  std::set<std::string> images;
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const std::string& image = problem.images[v];
    PlacedView view;
    if (poses[v]) view = Place(*file.camera, *poses[v], problem, v, pattern);
    if (view.size() < kMinViewFeatures) {
      check.rejected_images.push_back({image, "could not be localised"});
      continue;
    }
    views.push_back(std::move(view));
    images.insert(image);
  }
  if (views.empty())
    throw Error(ExitCode::kTooFew,
                "no image could be localised; are features and pattern those "
                "of this camera?");
  check.num_images = static_cast<int>(images.size());
  check.change = TestForChange(known, views);
  return check;
}

}  // namespace raygrid
