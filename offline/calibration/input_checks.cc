#include "calibration/input_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "calibration/model_selection.h"
#include "calibration/rig_initialization.h"
#include "calibration/rig_motion.h"
#include "calibration/rigid_target_search.h"
#include "camera/model_registry.h"
#include "dataset/error.h"
#include "dataset/repeated_images.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

// Requires a model that supports calibration; other parametric models have no
// prior for unobservable parameters yet.
void RequireKnownModel(const std::string& model) {
  std::vector<std::string> known = ListCalibratedModels();
  known.insert(known.begin(), kAutoModel);
  if (std::count(known.begin(), known.end(), model) > 0) return;
  if (IsParametricModel(model))
    throw Error(
        ExitCode::kUsage,
        fmt::format("model '{}' cannot be calibrated directly: calibrate "
                    "{}, then use raygrid fit or export",
                    model, models::kCentralGeneric));
  throw Error(ExitCode::kUsage,
              fmt::format("unknown model '{}'; use {}", model, OrList(known)));
}

void RequireImagesExist(const std::vector<CalibrationInput>& cameras,
                        const std::vector<std::string>& hold_out) {
  std::set<std::string> images;
  for (const CalibrationInput& camera : cameras)
    for (const ImageFeatures& image : camera.dataset.images)
      images.insert(image.image);
  for (const std::string& name : hold_out)
    if (images.count(name) == 0)
      throw Error(
          ExitCode::kUsage,
          fmt::format("--hold-out {}: {} of this name has features", name,
                      cameras.size() > 1 ? "no frame" : "no image"));
}

// Requires a rig that is connected by boards that two cameras observe in one
// frame, or by boards that may form a rigid target, also by their motion.
void RequireConnectedCameras(const std::vector<CalibrationInput>& cameras,
                             const Pattern& pattern, bool independent_boards) {
  std::vector<std::string> names;
  std::vector<Dataset> datasets;
  for (const CalibrationInput& camera : cameras) {
    names.push_back(camera.name);
    datasets.push_back(camera.dataset);
  }
  if (std::set<std::string>(names.begin(), names.end()).size() < names.size())
    throw Error(ExitCode::kUsage,
                "duplicate camera name; camera names must be unique");
  std::vector<RejectedImage> rejected;
  CalibrationProblem problem = BuildProblem(datasets, pattern, &rejected);
  std::vector<Pose> unknown_poses;
  if (!independent_boards) {
    JoinBoards(ProposeRigidTargets(datasets, pattern), &problem,
               &unknown_poses);
    if (CanConnectByMotion(problem, ConnectedGroups(problem))) return;
  }
  RequireConnected(names, problem);
}

// Rejects identical images for two cameras: they would form a rig with a zero
// baseline.
void RequireDistinctImages(const std::vector<CalibrationInput>& cameras) {
  for (size_t c = 1; c < cameras.size(); ++c)
    for (size_t other = 0; other < c; ++other) {
      const auto shared =
          FindSharedImage(cameras[other].dataset, cameras[c].dataset);
      if (!shared) continue;
      throw InputError(fmt::format(
          "cameras '{}' and '{}' share an image: {} and {} have the same "
          "features; use different images for each camera",
          cameras[other].name, cameras[c].name, shared->first, shared->second));
    }
}

void RequirePriorCameraFits(const std::vector<CalibrationInput>& cameras,
                            const CalibrationOptions& options) {
  if (!options.like) return;
  if ((options.model != models::kCentralGeneric &&
       options.model != kAutoModel) ||
      cameras.size() > 1)
    throw Error(ExitCode::kUsage,
                fmt::format("--prior requires a single camera and --model {}",
                            models::kCentralGeneric));
  const ImageSize size = options.like->image_size(),
                  own = cameras.front().dataset.image_size;
  if (size != own)
    throw Error(
        ExitCode::kUsage,
        fmt::format("--prior: calibrated for {}x{} px, but the images have "
                    "{}x{} px; use a camera of the same sensor mode",
                    size.width, size.height, own.width, own.height));
  if (!options.like->IsCentral())
    throw Error(ExitCode::kUsage, "--prior: the camera must be central");
}

void RequireKnownCamerasFit(const std::vector<CalibrationInput>& cameras) {
  for (const CalibrationInput& camera : cameras) {
    if (!camera.intrinsics) continue;
    if (cameras.size() == 1)
      throw Error(ExitCode::kUsage,
                  "the intrinsics of a single camera cannot be kept in a "
                  "calibration; estimate poses and target geometry instead");
    const ImageSize size = camera.intrinsics->camera->image_size(),
                    own = camera.dataset.image_size;
    if (size == own) continue;
    throw Error(ExitCode::kUsage,
                fmt::format("{}the known intrinsics are for images of {} x {} "
                            "px, but the images have {} x {} px; use a camera "
                            "of the same sensor mode",
                            camera.name.empty() ? "" : camera.name + ": ",
                            size.width, size.height, own.width, own.height));
  }
}

}  // namespace

void RequireValidInput(const std::vector<CalibrationInput>& cameras,
                       const Pattern& pattern,
                       const CalibrationOptions& options) {
  if (cameras.empty()) throw Error(ExitCode::kUsage, "no camera specified");
  RequireKnownModel(options.model);
  RequireImagesExist(cameras, options.hold_out);
  RequirePriorCameraFits(cameras, options);
  RequireKnownCamerasFit(cameras);
  RequireDistinctImages(cameras);
  if (cameras.size() > 1)
    RequireConnectedCameras(cameras, pattern, options.independent_boards);
}

void RequirePlausibleDistances(const AdjustmentResult& adjusted) {
  constexpr double kMaxDistanceM = 20;
  std::vector<double> distances_m;
  for (const View& view : adjusted.problem.views)
    distances_m.push_back(
        adjusted.state.ComputeCameraFromPattern(view).translation.norm());
  const double median_m = Quantile(distances_m, 0.5);
  if (median_m > kMaxDistanceM)
    throw Error(ExitCode::kUsage,
                fmt::format("the median distance of the boards is {:.3g} m, "
                            "above the limit of {:g} m: check square_m of the "
                            "pattern (in metres), or accept with --yes",
                            median_m, kMaxDistanceM));
}

}  // namespace raygrid
