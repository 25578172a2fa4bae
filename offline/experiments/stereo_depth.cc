#include <fmt/format.h>

#include <cmath>
#include <map>

#include "calibration/calibration.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "evaluation/residual_statistics.h"
#include "experiments/experiment.h"
#include "experiments/picture_sheet.h"
#include "experiments/stereo_matching.h"
#include "report/color_scale.h"
#include "simulation/random.h"
#include "simulation/simulated_lenses.h"
#include "simulation/simulated_rig.h"

namespace raygrid {
namespace {

constexpr double kBaselineM = 0.1, kDistanceM = 2, kSlope = 0.15;
constexpr Matching kMatching = {420, 10, 40};
constexpr int kDepthFrames = 4;

// ---- Scene -----------------------------------------------------------------

// A hash of a place, from 0 to 1, the same for the same place.
double Hash(int64_t x, int64_t y) {
  uint64_t h = static_cast<uint64_t>(x) * 0x9e3779b97f4a7c15u ^
               static_cast<uint64_t>(y) * 0xc2b2ae3d27d4eb4fu;
  h ^= h >> 29;
  h *= 0xbf58476d1ce4e5b9u;
  h ^= h >> 32;
  return static_cast<double>(h >> 11) * 0x1p-53;
}

double SmoothNoise(double x, double y) {
  const double x0 = std::floor(x), y0 = std::floor(y);
  const auto ease = [](double t) { return t * t * (3 - 2 * t); };
  const double u = ease(x - x0), v = ease(y - y0);
  const auto i = static_cast<int64_t>(x0), j = static_cast<int64_t>(y0);
  const double top = Hash(i, j) + u * (Hash(i + 1, j) - Hash(i, j));
  const double bottom =
      Hash(i, j + 1) + u * (Hash(i + 1, j + 1) - Hash(i, j + 1));
  return top + v * (bottom - top);
}

// Grey levels of a wall's paint, by metres.
double Paint(double x_m, double y_m) {
  double level = 0;
  for (const double wave_m : {0.018, 0.04, 0.1})
    level += SmoothNoise(x_m / wave_m + 1000 * wave_m, y_m / wave_m) / 3;
  return 30 + 200 * level;
}

// The wall z = kDistanceM + kSlope x in the left camera's frame.
Eigen::Vector3d OnWall(const ObservationLine& line) {
  const Eigen::Vector3d normal(-kSlope, 0, 1);
  const double depth =
      (kDistanceM - normal.dot(line.origin)) / normal.dot(line.direction);
  return line.origin + depth * line.direction;
}

// A photograph without noise.
cv::Mat RenderView(const CameraModel& camera, const Pose& left_from_camera,
                   int num_threads) {
  const ImageSize& size = camera.image_size();
  cv::Mat levels(size.height, size.width, CV_32F, cv::Scalar(0));
  ParallelFor(size.height, num_threads, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      double sum = 0;
      int count = 0;
      for (int k = 0; k < 4; ++k) {
        const auto line =
            camera.Line({x - 0.25 + 0.5 * (k % 2), y - 0.25 + 0.5 * (k / 2)});
        if (!line) continue;
        const Eigen::Vector3d point =
            OnWall({left_from_camera * line->origin,
                    left_from_camera.rotation * line->direction});
        sum += Paint(point.x(), point.y());
        ++count;
      }
      levels.at<float>(y, x) = static_cast<float>(sum / std::max(1, count));
    }
  });
  return levels;
}

cv::Mat WithNoise(const cv::Mat& levels, double read_noise, uint64_t seed) {
  Random random(seed);
  cv::Mat noisy = levels.clone();
  for (int y = 0; y < noisy.rows; ++y)
    for (int x = 0; x < noisy.cols; ++x)
      noisy.at<float>(y, x) += static_cast<float>(read_noise * random.Normal());
  return noisy;
}

// ---- Depth -----------------------------------------------------------------

// The depth errors of one image's map and of the mean of several, whose
// matching errors are still those of single windows; and of medians over blocks
// of that mean.
struct DepthErrors {
  double one_median_mm = 0, mean_median_mm = 0, blocks_rms_mm = 0, scale = 1;
  int columns = 0;
  std::vector<double> mean_mm;
};

double MedianSize(const std::vector<double>& values) {
  std::vector<double> sizes;
  for (const double value : values)
    if (std::isfinite(value)) sizes.push_back(std::abs(value));
  return Quantile(sizes, 0.5);
}

double BlocksRms(const std::vector<double>& values, int columns) {
  constexpr int kBlock = 8, kMinValues = kBlock * kBlock / 2;
  std::map<int, std::vector<double>> blocks;
  for (int k = 0; k < static_cast<int>(values.size()); ++k)
    if (std::isfinite(values[k]))
      blocks[k / columns / kBlock * columns + k % columns / kBlock].push_back(
          values[k]);
  double sum = 0;
  int count = 0;
  for (const auto& [block, errors] : blocks) {
    if (static_cast<int>(errors.size()) < kMinValues) continue;
    sum += std::pow(Quantile(errors, 0.5), 2);
    ++count;
  }
  return std::sqrt(sum / std::max(1, count));
}

DepthErrors MeasureFrames(const NamedStereo& cameras, const CameraModel& truth,
                          const cv::Mat& left, const cv::Mat& right,
                          const ExperimentOptions& options) {
  DepthErrors errors;
  const Surface wall =
      [&truth](const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector3d> {
    const auto line = truth.Line(pixel);
    if (!line) return std::nullopt;
    return OnWall(*line);
  };
  for (int frame = 0; frame < kDepthFrames; ++frame) {
    const uint64_t seed = options.seed * 1009 + 2 * frame;
    const StereoCloud cloud = MatchStereo(
        cameras, kMatching, WithNoise(left, options.read_noise, seed),
        WithNoise(right, options.read_noise, seed + 1),
        NumThreads(options.num_threads));
    const DepthErrorMap map = CompareToSurface(cloud, wall);
    errors.columns = map.columns;
    errors.scale = map.similarity_scale;
    if (frame == 0) {
      errors.one_median_mm = MedianSize(map.error_mm);
      errors.mean_mm.assign(map.error_mm.size(), 0);
    }
    for (size_t k = 0; k < map.error_mm.size(); ++k)
      errors.mean_mm[k] += map.error_mm[k] / kDepthFrames;
  }
  errors.mean_median_mm = MedianSize(errors.mean_mm);
  errors.blocks_rms_mm = BlocksRms(errors.mean_mm, errors.columns);
  return errors;
}

// ---- Calibration -----------------------------------------------------------

std::vector<NamedStereo> CalibratePairs(const SimulatedRig& rig,
                                        const ExperimentOptions& options) {
  const Pattern pattern = ChessboardPattern(30, 24, 0.02);
  SimulationOptions simulation;
  simulation.num_images = options.num_images;
  simulation.seed = options.seed + 1;
  const SimulatedRigObservations seen = SimulateRig(rig, pattern, simulation);
  CalibrationOptions calibration;
  calibration.flat_board = true;
  calibration.hold_out = {seen.datasets[0].images.back().image};
  calibration.num_threads = options.num_threads;
  calibration.cell_px =
      std::max(options.size.width, options.size.height) / 16.0;
  std::vector<NamedStereo> pairs;
  for (const char* model :
       {"opencv", "thin-prism-fisheye", "central-generic"}) {
    calibration.model = model;
    const RigResult result =
        Calibrate({{"left", seen.datasets[0]}, {"right", seen.datasets[1]}},
                  pattern, calibration);
    pairs.push_back(
        {model, result.cameras[0].camera.camera,
         result.cameras[1].camera.camera,
         result.camera_from_rig[1] * result.camera_from_rig[0].Inverse()});
    if (options.progress) options.progress(0.2 * double(pairs.size()));
  }
  pairs.push_back({"truth", rig.cameras[0], rig.cameras[1],
                   rig.camera_from_rig[1] * rig.camera_from_rig[0].Inverse()});
  return pairs;
}

Image DepthLegend(double limit_mm) {
  return ColorLegend(ColorScale::kEven, fmt::format("{:.3g}", -limit_mm),
                     fmt::format("{:.3g} mm", limit_mm));
}

// ---- A user's pair ---------------------------------------------------------

// The focal length that shows the middle as sharply as the left image.
double MiddleFocalPx(const CameraModel& camera) {
  constexpr double kStepPx = 4;
  const Eigen::Vector2d middle = camera.area().center(), step(kStepPx, 0);
  const auto left = camera.Unproject(middle - step);
  const auto right = camera.Unproject(middle + step);
  if (!left || !right)
    throw InputError("--rig: the left camera does not tell its middle");
  return 2 * kStepPx / left->cross(*right).norm();
}

cv::Mat ReadLevels(const std::string& path, const CameraModel& camera) {
  const GreyLevels grey = ReadGreyLevels(path);
  if (grey.size != camera.image_size())
    throw InputError(fmt::format(
        "{}: {} x {} pixels, but its camera is calibrated for {} x {}", path,
        grey.size.width, grey.size.height, camera.image_size().width,
        camera.image_size().height));
  return cv::Mat(grey.size.height, grey.size.width, CV_32F,
                 const_cast<float*>(grey.levels.data()))
      .clone();
}

ExperimentResult CompareUsersRigs(const ExperimentOptions& options) {
  const ExperimentData& data = options.data;
  if (data.rigs.size() < 2 || data.images.size() != 2)
    throw Error(ExitCode::kUsage,
                "stereo-depth: needs --rig twice or more, and two --image: "
                "the left camera's image, then the right one's");
  const NamedStereo& reference = data.rigs.back();
  const double nearest_m =
      data.nearest_m > 0 ? data.nearest_m : 10 * BaselineM(reference);
  Matching matching;
  matching.focal_px = MiddleFocalPx(*reference.left);
  matching.min_disparity = 1;
  matching.max_disparity = static_cast<int>(
      std::ceil(BaselineM(reference) * matching.focal_px / nearest_m));
  const int num_threads = NumThreads(options.num_threads);
  std::vector<StereoCloud> clouds;
  for (const NamedStereo& rig : data.rigs) {
    clouds.push_back(
        MatchStereo(rig, matching, ReadLevels(data.images[0], *rig.left),
                    ReadLevels(data.images[1], *rig.right), num_threads));
    if (options.progress)
      options.progress(double(clouds.size()) / double(data.rigs.size()));
  }
  const Surface surface = SurfaceOf(clouds.back(), reference, matching);

  ExperimentResult table;
  table.conditions = {
      {"images", data.images[0] + ", " + data.images[1]},
      {"matching",
       fmt::format("rectified, f = {:.0f} px; exhaustive along rows by "
                   "zero-mean normalised cross-correlation, {} px windows, "
                   "parabola; disparities of 1 to {} px, from {:.3g} m on",
                   matching.focal_px, 2 * Matching::kHalfWindowPx + 1,
                   matching.max_disparity, nearest_m)},
      {"aligned",
       "clouds to that with " + reference.name + " by a similarity (Umeyama)"},
      {"blocks", "of 8 x 8 matches"}};
  table.columns = {"cameras",         "baseline_m",
                   "matches",         "median_mm",
                   "blocks_rms_mm",   "blocks_rms_disparity_px",
                   "similarity_scale"};
  table.chart.title = "Differences of depth by stereo";
  table.chart.note = "from the last calibration, after a similarity";
  table.chart.x_label = "calibration";
  table.chart.y_label = "difference of depth, mm";
  ChartSeries median = {"median", {}, false},
              blocks = {"RMS of medians over blocks", {}, false};
  std::vector<SheetPicture> maps;
  double limit_mm = 0;
  for (size_t k = 0; k < clouds.size(); ++k) {
    const NamedStereo& rig = data.rigs[k];
    const DepthErrorMap map = CompareToSurface(clouds[k], surface);
    std::vector<double> disparity_px;  // d = b f / x
    for (size_t i = 0; i < map.error_mm.size(); ++i)
      disparity_px.push_back(map.error_mm[i] / 1000 * BaselineM(reference) *
                             matching.focal_px / std::pow(map.depth_m[i], 2));
    const double rms_mm = BlocksRms(map.error_mm, map.columns);
    const double place = static_cast<double>(k);
    table.rows.push_back(
        {rig.name, BaselineM(rig), map.num_matched, MedianSize(map.error_mm),
         rms_mm, BlocksRms(disparity_px, map.columns), map.similarity_scale});
    table.chart.ticks.push_back({place, rig.name});
    median.points.push_back({place, MedianSize(map.error_mm)});
    blocks.points.push_back({place, rms_mm});
    if (limit_mm == 0) limit_mm = std::max(2.5 * rms_mm, 1e-3);
    maps.push_back(
        {fmt::format("{}: blocks {:.1f} mm RMS", rig.name, rms_mm),
         HeatMap(map.error_mm, map.columns, -limit_mm, limit_mm, 3)});
  }
  table.chart.series = {median, blocks};
  const Image bar = DepthLegend(limit_mm);
  table.pictures.push_back(
      {"bias", PictureSheet(maps,
                            {"Depth less that with " + reference.name +
                                 " over the left rectified image:",
                             "below 0 nearer, above farther, white no match."},
                            &bar)});
  return table;
}

}  // namespace

ExperimentResult MeasureStereoDepth(const ExperimentOptions& options) {
  if (!options.data.rigs.empty() || !options.data.images.empty())
    return CompareUsersRigs(options);
  const std::shared_ptr<const CameraModel> lens =
      SimulatedLens("example", options.size);
  const SimulatedRig rig = CamerasInARow(lens, 2, kBaselineM);
  const std::vector<NamedStereo> pairs = CalibratePairs(rig, options);
  const int num_threads = NumThreads(options.num_threads);
  const cv::Mat left = RenderView(*lens, {}, num_threads);
  const cv::Mat right =
      RenderView(*lens, rig.camera_from_rig[1].Inverse(), num_threads);

  ExperimentResult table;
  const double mm_per_px =
      1000 * kDistanceM * kDistanceM / (kBaselineM * kMatching.focal_px);
  table.conditions = {
      {"scene", fmt::format("a painted wall, {:g} m away, inclined by {:g}",
                            kDistanceM, kSlope)},
      {"cameras", fmt::format("two alike, lens example, {:g} m apart, "
                              "calibrated together from {} instants",
                              kBaselineM, options.num_images)},
      {"matching",
       fmt::format("rectified, f = {:g} px; exhaustive along rows by zero-mean "
                   "normalised cross-correlation, {} px windows, parabola",
                   kMatching.focal_px, 2 * Matching::kHalfWindowPx + 1)},
      {"d = b f / x",
       fmt::format("1 px of disparity is {:.1f} mm of depth", mm_per_px)},
      {"aligned", "clouds to the wall by a similarity (Umeyama)"},
      {"blocks", "of 8 x 8 matches, in the mean of the images"},
      {"noise", fmt::format("{:g} grey levels", options.read_noise)},
      {"seed", std::to_string(options.seed)}};
  table.columns = {"cameras",
                   "one_image_median_mm",
                   fmt::format("mean_of_{}_median_mm", kDepthFrames),
                   "blocks_rms_mm",
                   "blocks_rms_disparity_px",
                   "similarity_scale"};
  table.chart.title = "Error of depth by stereo";
  table.chart.note =
      "noise and errors of single windows average out, a bias does not";
  table.chart.x_label = "calibration";
  table.chart.y_label = "error of depth, mm";
  table.chart.is_logarithmic = true;
  ChartSeries one = {"median, one image", {}, false},
              mean = {fmt::format("median, mean of {}", kDepthFrames),
                      {},
                      false},
              blocks = {"RMS of medians over blocks", {}, false};
  std::vector<SheetPicture> maps;
  double limit_mm = 0;
  for (const NamedStereo& pair : pairs) {
    const DepthErrors errors = MeasureFrames(pair, *lens, left, right, options);
    const double place = static_cast<double>(table.chart.ticks.size());
    table.rows.push_back({pair.name, errors.one_median_mm,
                          errors.mean_median_mm, errors.blocks_rms_mm,
                          errors.blocks_rms_mm / mm_per_px, errors.scale});
    table.chart.ticks.push_back({place, pair.name});
    one.points.push_back({place, errors.one_median_mm});
    mean.points.push_back({place, errors.mean_median_mm});
    blocks.points.push_back({place, errors.blocks_rms_mm});
    if (limit_mm == 0) limit_mm = 2.5 * errors.blocks_rms_mm;
    maps.push_back(
        {fmt::format("{}: blocks {:.1f} mm RMS", pair.name,
                     errors.blocks_rms_mm),
         HeatMap(errors.mean_mm, errors.columns, -limit_mm, limit_mm, 3)});
    if (options.progress) options.progress(0.6 + 0.1 * (place + 1));
  }
  table.chart.series = {one, mean, blocks};
  const Image bar = DepthLegend(limit_mm);
  table.pictures.push_back(
      {"bias",
       PictureSheet(maps,
                    {fmt::format("Depth less true depth, mean of {} image "
                                 "pairs, over the left rectified image:",
                                 kDepthFrames),
                     "below 0 too near, above too far, white no match."},
                    &bar)});
  return table;
}

}  // namespace raygrid
