#include "stereo_example.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "camera/equivalent_central_camera.h"
#include "dataset/error.h"
#include "packing/blob_camera.h"
#include "packing/pack.h"
#include "packing/rectification.h"

namespace raygrid {
namespace {

constexpr int kMaxPreviewWidthPx = 640;

// A feature observed by both cameras in the same frame.
struct SharedFeature {
  Eigen::Vector2d left_px, right_px;
};
using SharedByFrame = std::map<std::string, std::vector<SharedFeature>>;

SharedByFrame ShareFeatures(const Dataset& left, const Dataset& right) {
  std::map<std::tuple<std::string, int, int, int>, Eigen::Vector2d>
      J_board_pose;
  for (const ImageFeatures& image : right.images)
    for (const Feature& f : image.features)
      J_board_pose[{image.image, f.board, f.column, f.row}] = f.pixel;
  SharedByFrame shared;
  for (const ImageFeatures& image : left.images)
    for (const Feature& f : image.features) {
      const auto found =
          J_board_pose.find({image.image, f.board, f.column, f.row});
      if (found != J_board_pose.end())
        shared[image.image].push_back({f.pixel, found->second});
    }
  return shared;
}

// Returns the distance from a camera to the nearest board in a frame.
std::optional<double> BoardDistanceM(const CalibrationResult& camera,
                                     const std::string& frame) {
  std::optional<double> nearest;
  for (const BoardPose& pose : camera.poses) {
    if (pose.image != frame) continue;
    const double distance = pose.camera_from_board.translation.norm();
    nearest = std::min(nearest.value_or(distance), distance);
  }
  return nearest;
}

// The cameras of the pair, in the order of the rectified images.
struct ExamplePair {
  size_t left = 0, right = 0;
  SharedByFrame shared;
  std::string frame;
  std::optional<double> distance_m;  // scene distance, for non-central cameras
};

std::optional<ExamplePair> ChoosePair(const RigResult& result,
                                      const Baseline& baseline) {
  ExamplePair pair = {baseline.first, baseline.second, {}, "", {}};
  if (IsOrderReversed(result.camera_from_rig[pair.right] *
                      result.camera_from_rig[pair.left].Inverse()))
    std::swap(pair.left, pair.right);
  const CalibrationResult& left = result.cameras[pair.left];
  const CalibrationResult& right = result.cameras[pair.right];
  pair.shared = ShareFeatures(left.features, right.features);
  size_t most = 0;
  for (const auto& [frame, features] : pair.shared) {
    if (features.size() <= most) continue;
    most = features.size();
    pair.frame = frame;
  }
  if (most == 0) return std::nullopt;
  if (!left.camera.camera->IsCentral())
    pair.distance_m = BoardDistanceM(left, pair.frame).value_or(1);
  return pair;
}

std::unique_ptr<CameraModel> CentralCamera(const CalibrationResult& camera,
                                           const ExamplePair& pair) {
  const CameraModel& model = *camera.camera.camera;
  if (pair.distance_m)
    return std::make_unique<EquivalentCentralCamera>(model, *pair.distance_m);
  return model.Clone();
}

// An image undistorted by the runtime, and the mask of pixels with a source.
struct MaskedImage {
  Image image, shown;
};

// Returns a camera's image of the frame, rectified; nullopt if the file no
// longer exists.
std::optional<MaskedImage> RectifiedImage(const Measurements& measured,
                                          const CameraFile& camera,
                                          const VirtualView& view,
                                          const ExamplePair& pair,
                                          int num_threads) {
  PackOptions options;
  options.remaps = {view};
  if (pair.distance_m)
    options.remaps[0].scene = SceneSurface{*pair.distance_m, {}};
  options.max_error_px = 0.25;
  options.num_threads = num_threads;
  const auto& images = measured.dataset.images;
  for (size_t i = 0; i < std::min(images.size(), measured.paths.size()); ++i) {
    if (images[i].image != pair.frame) continue;
    const BlobCamera blob("packed camera", PackCamera(camera, options).blob);
    Image image = ReadImage(measured.paths[i], true);
    const Image rectified = blob.Undistort(image, 0);
    std::fill(image.pixels.begin(), image.pixels.end(), uint8_t{255});
    return MaskedImage{rectified, blob.Undistort(image, 0)};
  }
  return std::nullopt;
}

// Computes the metrics of all shared features; returns the maximum disparity of
// those in the example frame, as a fraction of the focal length.
double MeasureRows(const ExamplePair& pair, const Rectification& rectified,
                   const CameraModel& left, const CameraModel& right,
                   StereoMetrics* metrics) {
  const int along = rectified.is_vertical ? 1 : 0, across = 1 - along;
  double largest = 0, sum = 0;
  for (const auto& [frame, features] : pair.shared)
    for (const SharedFeature& feature : features) {
      const auto a = left.Unproject(feature.left_px);
      const auto b = right.Unproject(feature.right_px);
      const auto in_a = a ? rectified.views[0].Pixel(*a) : std::nullopt;
      const auto in_b = b ? rectified.views[1].Pixel(*b) : std::nullopt;
      if (!in_a || !in_b) continue;
      const Eigen::Vector2d difference = *in_a - *in_b;
      sum += difference[across] * difference[across];
      metrics->max_px = std::max(metrics->max_px, std::abs(difference[across]));
      ++metrics->num_features;
      if (frame == pair.frame)
        largest = std::max(
            largest, difference[along] / rectified.views[0].focal_px[along]);
    }
  metrics->rms_px = std::sqrt(sum / std::max(1, metrics->num_features));
  return largest;
}

ImageSize ComputePreviewSize(const ImageSize& size) {
  if (size.width <= kMaxPreviewWidthPx) return size;
  return {kMaxPreviewWidthPx,
          std::max(1, size.height * kMaxPreviewWidthPx / size.width)};
}

// Returns slightly more than the disparities of the boards, but at most the
// image's length: a larger range would cause wrong matches of repetitive
// patterns at smaller distances.
int NumDisparities(double largest_px, int length_px) {
  constexpr int kUnit = 16, kDisparityMarginPx = 8;
  const int wanted =
      static_cast<int>(
          std::ceil((std::max(0.0, largest_px) + kDisparityMarginPx) / kUnit)) *
      kUnit;
  return std::min(wanted, std::max(kUnit, length_px / kUnit * kUnit));
}

// Shows all of both images (alpha = 1) unless that stretches them too much.
Rectification RectifyForPreview(const StereoCamera& first,
                                const StereoCamera& second) {
  constexpr double kMaxDeg = 120;
  RectificationRequest request;
  request.size = ComputePreviewSize(first.camera.image_size());
  try {
    request.alpha = 1;
    const Rectification all = Rectify(first, second, request);
    if (all.views[0].HorizontalFieldOfViewDeg() < kMaxDeg) return all;
  } catch (const Error&) {
    // No pinhole view shows all of the image.
  }
  request.alpha = 0;
  return Rectify(first, second, request);
}

std::optional<StereoExample> MakePairExample(
    const std::vector<Measurements>& cameras, const RigResult& result,
    const ExamplePair& pair, int num_threads) {
  const CalibrationResult& left = result.cameras[pair.left];
  const CalibrationResult& right = result.cameras[pair.right];
  const auto central_left = CentralCamera(left, pair);
  const auto central_right = CentralCamera(right, pair);
  const StereoCamera first = {left.camera.name, *central_left,
                              result.camera_from_rig[pair.left]};
  const StereoCamera second = {right.camera.name, *central_right,
                               result.camera_from_rig[pair.right]};
  StereoExample example;
  StereoMetrics& metrics = example.metrics;
  metrics.left = first.name;
  metrics.right = second.name;
  metrics.frame = pair.frame;
  const double largest = MeasureRows(pair, Rectify(first, second, {}),
                                     *central_left, *central_right, &metrics);
  const Rectification small = RectifyForPreview(first, second);
  metrics.is_vertical = small.is_vertical;
  const VirtualView& view = small.views[0];
  metrics.num_disparities =
      NumDisparities(largest * view.focal_px.x(),
                     small.is_vertical ? view.size.height : view.size.width);
  const auto masked_left =
      RectifiedImage(cameras[pair.left], left.camera, view, pair, num_threads);
  const auto masked_right = RectifiedImage(cameras[pair.right], right.camera,
                                           small.views[1], pair, num_threads);
  if (!masked_left || !masked_right) return std::nullopt;
  const RectifiedImages images = {masked_left->image, masked_right->image,
                                  masked_left->shown, small.is_vertical};
  example.rows = DrawRectifiedRows(images);
  example.disparity = DrawDisparityMap(images, metrics.num_disparities);
  return example;
}

}  // namespace

std::optional<StereoExample> MakeStereoExample(
    const std::vector<Measurements>& cameras, const RigResult& result,
    int num_threads) {
  std::vector<Baseline> baselines = result.baselines;
  std::stable_sort(baselines.begin(), baselines.end(),
                   [](const Baseline& a, const Baseline& b) {
                     return a.num_shared_views > b.num_shared_views;
                   });
  for (const Baseline& baseline : baselines) {
    if (cameras[baseline.first].paths.empty() ||
        cameras[baseline.second].paths.empty())
      continue;
    const auto pair = ChoosePair(result, baseline);
    if (!pair) continue;
    try {
      if (auto example = MakePairExample(cameras, result, *pair, num_threads))
        return example;
    } catch (const Error&) {
      // The pair cannot be rectified, packed or read: there is no example.
    }
  }
  return std::nullopt;
}

}  // namespace raygrid
