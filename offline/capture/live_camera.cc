#include "capture/live_camera.h"

#include <algorithm>
#include <map>

#include "calibration/camera_initialization.h"
#include "capture/next_view.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

constexpr double kCells = 16;  // grid cells along the longer image side

}  // namespace

LiveCamera::LiveCamera(const Pattern& pattern, const ImageSize& size,
                       int num_threads)
    : pattern_(pattern), num_threads_(num_threads) {
  images_.image_size = size;
}

AdjustmentOptions LiveCamera::MakeAdjustmentOptions() const {
  AdjustmentOptions options;
  options.fix_points = true;
  options.num_threads = num_threads_;
  return options;
}

void LiveCamera::Add(const ImageFeatures& image) {
  images_.images.push_back(image);
  const size_t count = images_.images.size();
  if (count < kNumFirstViews) return;
  if (!adjusted_ || 2 * count >= 3 * num_images_at_full_adjustment_)
    OptimizeFromScratch();
  else
    ContinueOptimization();
}

void LiveCamera::Add(const std::vector<ImageFeatures>& images) {
  images_.images.insert(images_.images.end(), images.begin(), images.end());
  if (images_.images.size() >= kNumFirstViews) OptimizeFromScratch();
}

void LiveCamera::Remove(const std::string& image) {
  auto& images = images_.images;
  images.erase(std::remove_if(images.begin(), images.end(),
                              [&image](const ImageFeatures& other) {
                                return other.image == image;
                              }),
               images.end());
  adjusted_.reset();
  if (images.size() >= kNumFirstViews) OptimizeFromScratch();
}

void LiveCamera::OptimizeFromScratch() {
  const double knot_spacing_px =
      std::max(images_.image_size.width, images_.image_size.height) / kCells;
  try {
    AdjustmentResult adjusted =
        InitializeCamera(images_, pattern_, MakeAdjustmentOptions());
    OptimizeWithRigidBoards(pattern_, models::kCentralGeneric,
                            {knot_spacing_px}, MakeAdjustmentOptions(),
                            &adjusted);
    adjusted_ = std::move(adjusted);
    num_images_at_full_adjustment_ = images_.images.size();
  } catch (const Error&) {
    // Not enough images: later ones may determine the missing parameters.
    if (adjusted_) ContinueOptimization();
  }
}

void LiveCamera::ContinueOptimization() {
  std::map<std::pair<std::string, int>, Pose> poses;
  const CalibrationProblem& before = adjusted_->problem;
  for (size_t v = 0; v < before.views.size(); ++v)
    poses[{before.images[v], before.boards[v]}] =
        adjusted_->state.rig_from_pattern[before.views[v].pose];
  AdjustmentResult next = *adjusted_;
  std::vector<RejectedImage> rejected;
  next.problem = BuildProblem({images_}, pattern_, &rejected);
  next.problem.area = before.area;
  const auto known_pose = [&](size_t v) {
    return poses.find({next.problem.images[v], next.problem.boards[v]});
  };
  CalibrationProblem added = next.problem;
  std::vector<bool> remove;
  for (size_t v = 0; v < next.problem.views.size(); ++v)
    remove.push_back(known_pose(v) != poses.end());
  RemoveViews(remove, &added);
  const auto localized =
      LocalizeViews(next.state.camera(), 0, added, num_threads_);
  std::vector<Pose> kept;
  auto next_added_pose = localized.begin();
  for (size_t v = 0; v < next.problem.views.size(); ++v) {
    const auto known = known_pose(v);
    const std::optional<Pose> pose =
        known != poses.end() ? known->second : *next_added_pose++;
    remove[v] = !pose;
    if (pose) kept.push_back(*pose);
  }
  RemoveViews(remove, &next.problem);
  next.state.rig_from_pattern = kept;
  next.state.SetModes({}, DeformationScope::kBoard);
  const double noise_px = next.summary.noise_px;
  next.summary = RunBundleAdjustment(next.problem.views, next.prior,
                                     MakeAdjustmentOptions(), &next.state);
  next.summary.noise_px = noise_px;
  adjusted_ = std::move(next);
}

}  // namespace raygrid
