#include <fmt/format.h>

#include <cmath>
#include <map>

#include "calibration/calibration.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "evaluation/residual_statistics.h"
#include "experiments/calibrated_cameras.h"
#include "experiments/montage.h"
#include "experiments/painted_wall.h"
#include "experiments/stereo_matching.h"
#include "report/color_scale.h"
#include "simulation/random.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_rig.h"

namespace raygrid {
namespace {

constexpr double kBaselineM = 0.1;
constexpr double kWallDistanceInBaselines = 20;
constexpr Matching kMatching = {420, 10, 40};
constexpr int kDepthFrames = 4;

// ---- Scene -----------------------------------------------------------------

cv::Mat WithNoise(const cv::Mat& levels, double read_noise, uint64_t seed) {
  Random random(seed);
  cv::Mat noisy = levels.clone();
  for (int y = 0; y < noisy.rows; ++y)
    for (int x = 0; x < noisy.cols; ++x)
      noisy.at<float>(y, x) += static_cast<float>(read_noise * random.Normal());
  return noisy;
}

// ---- Depth -----------------------------------------------------------------

// Depth errors: (1) of a single image's map, (2) of the mean over several
// images, which still contains the matching errors of individual windows, and
// (3) of medians over blocks of that mean.
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

DepthErrors MeasureFrames(const StereoRig& cameras, const Matching& matching,
                          const Surface& wall, const cv::Mat& left,
                          const cv::Mat& right,
                          const ExperimentOptions& options) {
  DepthErrors errors;
  for (int frame = 0; frame < kDepthFrames; ++frame) {
    const uint64_t seed = options.seed * 1009 + 2 * frame;
    const StereoCloud cloud = MatchStereo(
        cameras, matching, WithNoise(left, options.read_noise, seed),
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

// The compared pairs. The last is the ground truth, or serves as the reference.
struct ComparedPairs {
  std::vector<StereoRig> pairs;
  std::vector<Condition> conditions;
  bool is_simulated = false;  // both ground truth and images

  const StereoRig& truth() const { return pairs.back(); }
};

// Calibrates with the defaults of `raygrid calibrate`: target points are
// estimated.
void CalibratePairs(const Dataset& left, const Dataset& right,
                    const Pattern& pattern,
                    const std::vector<std::string>& hold_out,
                    const ExperimentOptions& options, ComparedPairs* compared) {
  CalibrationOptions calibration;
  calibration.hold_out = hold_out;
  calibration.num_threads = options.num_threads;
  // For the user's features, the last model is the paper's reference.
  for (const std::string& model :
       ListModelNames(ModelUse::kAuto,
                      {models::kNonCentralGeneric, models::kCentralGeneric})) {
    calibration.model = model;
    const RigResult result =
        Calibrate({{"left", left}, {"right", right}}, pattern, calibration);
    compared->pairs.push_back(
        {model, result.cameras[0].camera.camera,
         result.cameras[1].camera.camera,
         result.camera_from_rig[1] * result.camera_from_rig[0].Inverse(),
         ComputeWellDeterminedMask(result.cameras[0].camera),
         ComputeWellDeterminedMask(result.cameras[1].camera)});
    if (options.progress)
      options.progress(0.15 * double(compared->pairs.size()));
  }
  compared->conditions.push_back(
      {"calibrated",
       fmt::format(
           "each model from the same {} and {} images; target geometry "
           "estimated, knot spacing by cross-validation, as in calibrate",
           left.images.size(), right.images.size())});
}

ComparedPairs SimulatePairs(const ExperimentOptions& options) {
  const SimulatedRig rig = MakeCameraRow(
      MakeSimulatedCamera("example", options.size), 2, kBaselineM);
  const Pattern pattern = ChessboardPattern(30, 24, 0.02);
  SimulationOptions simulation;
  simulation.num_images = options.num_images;
  simulation.seed = options.seed + 1;
  const SimulatedRigObservations seen = SimulateRig(rig, pattern, simulation);
  ComparedPairs compared;
  compared.is_simulated = true;
  CalibratePairs(seen.datasets[0], seen.datasets[1], pattern,
                 {seen.datasets[0].images.back().image}, options, &compared);
  compared.pairs.push_back(
      {"truth", rig.cameras[0], rig.cameras[1],
       rig.camera_from_rig[1] * rig.camera_from_rig[0].Inverse()});
  compared.conditions.push_back(
      {"cameras", fmt::format("two identical ones, lens example, {:g} m apart",
                              kBaselineM)});
  return compared;
}

// Returns the pairs calibrated from the user's features, or the user's rigs.
ComparedPairs SelectUserPairs(const ExperimentOptions& options) {
  const ExperimentData& data = options.data;
  ComparedPairs compared;
  std::string others = "the others as specified";
  if (data.pair_features) {
    const auto& [left, right] = *data.pair_features;
    std::vector<std::string> hold_out = data.hold_out;
    if (hold_out.empty()) hold_out = {left.images.back().image};
    CalibratePairs(left, right, data.pattern, hold_out, options, &compared);
    others = "the others calibrated from the same features";
  } else if (data.rigs.size() == 1) {
    const StereoRig& rig = data.rigs[0];
    const auto left = FitModels({rig.name, rig.left, rig.left_known});
    const auto right = FitModels({rig.name, rig.right, rig.right_known});
    for (const FittedCamera& l : left)
      for (const FittedCamera& r : right)
        if (l.camera.name == r.camera.name)
          compared.pairs.push_back(
              {l.camera.name, l.camera.model, r.camera.model,
               Pose{r.fitted_from_camera, {0, 0, 0}} * rig.right_from_left *
                   Pose{l.fitted_from_camera, {0, 0, 0}}.Inverse()});
    compared.pairs.push_back(rig);
    others = "the others are fitted to its cameras";
  } else {
    compared.pairs = data.rigs;
  }
  compared.conditions.push_back(
      {"truth",
       fmt::format(
           "not available; {} serves as reference, {}; evaluated where its "
           "predicted uncertainty is below {:g} px or below its median",
           compared.truth().name, others, kKnownPx)});
  return compared;
}

Image DrawDepthLegend(double limit_mm) {
  return DrawColorLegend(ColorScale::kEven, fmt::format("{:.3g}", -limit_mm),
                         fmt::format("{:.3g} mm", limit_mm));
}

// ---- A user's pair ---------------------------------------------------------

// Returns the focal length with the resolution of the left image's centre.
double CenterFocalPx(const CameraModel& camera) {
  constexpr double kStepPx = 4;
  const Eigen::Vector2d center = camera.area().center(), step(kStepPx, 0);
  const auto left = camera.Unproject(center - step);
  const auto right = camera.Unproject(center + step);
  if (!left || !right)
    throw InputError("--rig: the left camera model is undefined at its centre");
  return 2 * kStepPx / left->cross(*right).norm();
}

cv::Mat ReadGreyLevelImage(const std::string& path, const CameraModel& camera) {
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

// Compares the depths from a user's images with those of the last pair.
ExperimentResult CompareOnImages(const ComparedPairs& compared,
                                 const ExperimentOptions& options) {
  const ExperimentData& data = options.data;
  const StereoRig& reference = compared.truth();
  const double min_distance_m =
      data.min_distance_m > 0 ? data.min_distance_m : 10 * BaselineM(reference);
  Matching matching;
  matching.focal_px = CenterFocalPx(*reference.left);
  matching.min_disparity = 1;
  matching.max_disparity = static_cast<int>(
      std::ceil(BaselineM(reference) * matching.focal_px / min_distance_m));
  const int num_threads = NumThreads(options.num_threads);
  std::vector<StereoCloud> clouds;
  for (const StereoRig& rig : compared.pairs) {
    clouds.push_back(MatchStereo(
        rig, matching, ReadGreyLevelImage(data.images[0], *rig.left),
        ReadGreyLevelImage(data.images[1], *rig.right), num_threads));
    if (options.progress)
      options.progress(0.6 + 0.4 * double(clouds.size()) /
                                 double(compared.pairs.size()));
  }
  const Surface surface = MakeSurface(clouds.back(), reference, matching);

  ExperimentResult table;
  table.conditions = compared.conditions;
  const std::vector<Condition> conditions = {
      {"images", data.images[0] + ", " + data.images[1]},
      {"matching",
       fmt::format(
           "rectified, f = {:.0f} px; exhaustive along rows by zero-mean "
           "normalised cross-correlation, {} px windows, parabola; disparities "
           "of 1 to {} px, depth at least {:.3g} m",
           matching.focal_px, 2 * Matching::kHalfWindowPx + 1,
           matching.max_disparity, min_distance_m)},
      {"aligned", "point clouds aligned to that with " + reference.name +
                      " by a similarity (Umeyama) without outliers"},
      {"blocks", "of 8 x 8 matches"}};
  table.conditions.insert(table.conditions.end(), conditions.begin(),
                          conditions.end());
  table.columns = {"cameras",         "baseline_m",
                   "matches",         "median_mm",
                   "blocks_rms_mm",   "blocks_rms_disparity_px",
                   "similarity_scale"};
  table.chart.title = "Stereo depth differences";
  table.chart.note = "from the last calibration, after a similarity transform";
  table.chart.x_label = "calibration";
  table.chart.y_label = "depth difference, mm";
  ChartSeries median = {"median", {}, false},
              blocks = {"RMS of medians over blocks", {}, false};
  std::vector<MontageImage> maps;
  double limit_mm = 0;
  for (size_t k = 0; k < clouds.size(); ++k) {
    const StereoRig& rig = compared.pairs[k];
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
  const Image bar = DrawDepthLegend(limit_mm);
  table.pictures.push_back(
      {"bias",
       ComposeMontage(maps,
                      {"Depth difference from " + reference.name +
                           ", in the left rectified image:",
                       "negative: nearer, positive: farther, white: no match."},
                      &bar)});
  return table;
}

// ---- A painted wall --------------------------------------------------------

// Returns the disparity range for a wall in front of a pair, with a margin for
// its slope.
Matching MatchOnWall(const StereoRig& pair) {
  constexpr double kMinDisparityRatio = 0.48, kMaxDisparityRatio = 1.9;
  Matching matching;
  matching.focal_px = CenterFocalPx(*pair.left);
  const double disparity_px = matching.focal_px / kWallDistanceInBaselines;
  matching.min_disparity = std::max(
      1, static_cast<int>(std::floor(kMinDisparityRatio * disparity_px)));
  matching.max_disparity =
      static_cast<int>(std::ceil(kMaxDisparityRatio * disparity_px));
  return matching;
}

// Measures the depths of a wall in images rendered with the last pair.
ExperimentResult CompareOnWall(const ComparedPairs& compared,
                               const ExperimentOptions& options) {
  const StereoRig& truth = compared.truth();
  const double baseline_m = BaselineM(truth);
  const PaintedWall wall(kWallDistanceInBaselines * baseline_m);
  const Matching matching =
      compared.is_simulated ? kMatching : MatchOnWall(truth);
  const int num_threads = NumThreads(options.num_threads);
  const cv::Mat left = wall.Photograph(*truth.left, {}, num_threads);
  const cv::Mat right = wall.Photograph(
      *truth.right, truth.right_from_left.Inverse(), num_threads);
  const Surface surface =
      [&](const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector3d> {
    const auto line = truth.left->Line(pixel);
    const auto& known = truth.left_known;
    if (!line || (known && !known->IsValidAt(pixel))) return std::nullopt;
    return wall.IntersectRay(*line);
  };

  ExperimentResult table;
  const double mm_per_px =
      1000 * std::pow(wall.distance_m(), 2) / (baseline_m * matching.focal_px);
  table.conditions = compared.conditions;
  const std::vector<Condition> conditions = {
      {"scene", fmt::format("a textured wall, {:.3g} m away, slope {:g}, "
                            "rendered with the true cameras",
                            wall.distance_m(), PaintedWall::kSlope)},
      {"matching",
       fmt::format(
           "rectified, f = {:.0f} px; exhaustive along rows by zero-mean "
           "normalised cross-correlation, {} px windows, parabola; then "
           "triangulation with the observation lines of both pixels",
           matching.focal_px, 2 * Matching::kHalfWindowPx + 1)},
      {"d = b f / x",
       fmt::format("1 px of disparity is {:.1f} mm of depth", mm_per_px)},
      {"aligned",
       "point clouds aligned to the wall by a similarity (Umeyama) without "
       "outliers"},
      {"blocks", "of 8 x 8 matches, mean over images"},
      {"noise", fmt::format("{:g} grey levels", options.read_noise)},
      {"seed", std::to_string(options.seed)}};
  table.conditions.insert(table.conditions.end(), conditions.begin(),
                          conditions.end());
  table.columns = {"cameras",
                   "one_image_median_mm",
                   fmt::format("mean_of_{}_median_mm", kDepthFrames),
                   "blocks_rms_mm",
                   "blocks_rms_disparity_px",
                   "similarity_scale"};
  table.chart.title = "Stereo depth error";
  table.chart.note = "noise and matching errors average out, bias does not";
  table.chart.x_label = "calibration";
  table.chart.y_label = "depth error, mm";
  table.chart.is_logarithmic = true;
  ChartSeries one = {"median, one image", {}, false},
              mean = {fmt::format("median, mean of {}", kDepthFrames),
                      {},
                      false},
              blocks = {"RMS of medians over blocks", {}, false};
  std::vector<MontageImage> maps;
  double limit_mm = 0;
  for (const StereoRig& pair : compared.pairs) {
    const DepthErrors errors =
        MeasureFrames(pair, matching, surface, left, right, options);
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
    if (options.progress)
      options.progress(0.6 + 0.4 * (place + 1) / double(compared.pairs.size()));
  }
  table.chart.series = {one, mean, blocks};
  const Image bar = DrawDepthLegend(limit_mm);
  table.pictures.push_back(
      {"bias", ComposeMontage(
                   maps,
                   {fmt::format("Depth error, mean of {} image pairs, in the "
                                "left rectified image:",
                                kDepthFrames),
                    "negative: too near, positive: too far, white: no match."},
                   &bar)});
  return table;
}

}  // namespace

ExperimentResult MeasureStereoDepth(const ExperimentOptions& options) {
  const ExperimentData& data = options.data;
  const bool is_users = data.pair_features || !data.rigs.empty();
  if (!data.images.empty() && (data.images.size() != 2 || !is_users))
    throw Error(ExitCode::kUsage,
                "stereo-depth: --image requires two images (left, then right) "
                "and a --rig, or --features of a stereo pair");
  const ComparedPairs compared =
      is_users ? SelectUserPairs(options) : SimulatePairs(options);
  return data.images.empty() ? CompareOnWall(compared, options)
                             : CompareOnImages(compared, options);
}

}  // namespace raygrid
