#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "evaluation/residual_statistics.h"
#include "experiments/calibrated_cameras.h"
#include "initialization/localization.h"
#include "simulation/random.h"

namespace raygrid {
namespace {

// As in the paper, "Camera Localization": 15 random pixels, at distances of 1.5
// to 2.5 m.
constexpr int kPoints = 15, kScenes = 100;
constexpr double kNearM = 1.5, kFarM = 2.5, kNoisePx = 0.05;
constexpr int kNumFrames[] = {1, 4, 16, 64};
constexpr int kMaxFrames = 64;

// Returns points in the frame of the true camera, whose pose is the identity,
// at pixels in the valid regions of all cameras.
std::vector<PointPixelMatch> MakeScene(const ComparedCameras& compared,
                                       const Area& area, Random* random) {
  constexpr int kMaxTries = 10000;
  std::vector<PointPixelMatch> scene;
  for (int tries = 0; static_cast<int>(scene.size()) < kPoints; ++tries) {
    if (tries == kMaxTries)
      throw Error(ExitCode::kInsufficientData,
                  "localization: the valid regions of the cameras hardly "
                  "overlap; calibrate from more images");
    const double x = random->Uniform(area.x0 + 1, area.x1 - 1);
    const Eigen::Vector2d pixel(x, random->Uniform(area.y0 + 1, area.y1 - 1));
    const double distance_m = random->Uniform(kNearM, kFarM);
    if (!AreAllDefined(compared, pixel)) continue;
    const auto line = compared.truth().Line(pixel);
    scene.push_back({line->origin + distance_m * line->direction, pixel});
  }
  return scene;
}

// For each number of averaged frames, the error of the estimated camera
// position in the true camera's frame; nullopt if pose estimation fails.
using Errors = std::vector<std::optional<Eigen::Vector3d>>;

Errors LocalizeScene(const CameraModel& camera,
                     const std::vector<PointPixelMatch>& scene, uint64_t seed) {
  Random random(seed);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  Errors errors;
  for (int frame = 1; frame <= kMaxFrames; ++frame) {
    std::vector<PointPixelMatch> seen = scene;
    for (PointPixelMatch& match : seen) {
      match.pixel.x() += kNoisePx * random.Normal();
      match.pixel.y() += kNoisePx * random.Normal();
    }
    if (const auto pose = Localize(camera, seen)) {
      sum += pose->Inverse().translation;
      ++count;
    }
    if (std::find(std::begin(kNumFrames), std::end(kNumFrames), frame) ==
        std::end(kNumFrames))
      continue;
    errors.emplace_back();
    if (count > 0) errors.back() = sum / count;
  }
  return errors;
}

double ComputeMedianLength(const std::vector<Errors>& scenes, size_t k,
                           const Eigen::Vector3d& offset) {
  std::vector<double> lengths;
  for (const Errors& scene : scenes)
    if (scene[k]) lengths.push_back((*scene[k] - offset).norm());
  return lengths.empty() ? NAN : Quantile(lengths, 0.5);
}

// Returns the median over scenes, per axis, of the error after averaging all
// frames.
Eigen::Vector3d ComputeSharedOffset(const std::vector<Errors>& scenes) {
  Eigen::Vector3d offset;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Errors& scene : scenes)
      if (scene.back()) values.push_back((*scene.back())[axis]);
    offset[axis] = values.empty() ? NAN : Quantile(values, 0.5);
  }
  return offset;
}

// Medians over scenes.
struct PositionErrors {
  std::vector<double> frame_errors_m;
  double shared_m = 0;    // offset common to all scenes
  double residual_m = 0;  // the remainder after averaging all frames
};

PositionErrors MeasurePositionErrors(const CameraModel& camera,
                                     const ComparedCameras& compared,
                                     const ExperimentOptions& options) {
  const Area area = ComputeCommonArea(compared.cameras);
  std::vector<Errors> scenes(kScenes);
  ParallelFor(kScenes, NumThreads(options.num_threads), [&](int i) {
    Random random(options.seed * 1000003 + i + 1);
    const std::vector<PointPixelMatch> scene =
        MakeScene(compared, area, &random);
    scenes[i] = LocalizeScene(camera, scene, options.seed * 7919 + i + 1);
  });
  PositionErrors errors;
  for (size_t k = 0; k < std::size(kNumFrames); ++k)
    errors.frame_errors_m.push_back(
        ComputeMedianLength(scenes, k, Eigen::Vector3d::Zero()));
  const Eigen::Vector3d offset = ComputeSharedOffset(scenes);
  errors.shared_m = offset.norm();
  errors.residual_m =
      ComputeMedianLength(scenes, std::size(kNumFrames) - 1, offset);
  return errors;
}

}  // namespace

ExperimentResult LocalizeByModels(const ExperimentOptions& options) {
  // For the user's features, the last model is the paper's reference.
  const ComparedCameras compared = SelectComparedCameras(
      options, ListModelNames(ModelUse::kCompare, {models::kNonCentralGeneric,
                                                   models::kCentralGeneric}));
  ExperimentResult table;
  table.conditions = compared.conditions;
  table.conditions.push_back(
      {"scenes",
       fmt::format(
           "{} of {} points at random pixels in the valid region of all "
           "cameras, {:g} to {:g} m away, noise {:g} px per axis; medians",
           kScenes, kPoints, kNearM, kFarM, kNoisePx)});
  table.conditions.push_back(
      {"shared", fmt::format("position offset in the camera frame common to "
                             "all scenes; rest: mean of {} without it",
                             kMaxFrames)});
  table.columns = {"camera"};
  table.chart.title = "Camera position error";
  table.chart.note =
      "median over scenes; noise averages out, calibration error does not";
  table.chart.x_label = "images averaged";
  table.chart.y_label = "error, mm";
  table.chart.is_logarithmic = true;
  for (const int frames : kNumFrames) {
    table.columns.push_back(fmt::format("mean_of_{}_mm", frames));
    table.chart.ticks.push_back(
        {double(table.chart.ticks.size()), std::to_string(frames)});
  }
  for (const char* column : {"shared_mm", "rest_mm"})
    table.columns.emplace_back(column);
  for (const NamedCamera& camera : compared.cameras) {
    const PositionErrors errors =
        MeasurePositionErrors(*camera.model, compared, options);
    std::vector<Cell> row;
    row.emplace_back(camera.name);
    ChartSeries series = {camera.name, {}, true};
    for (size_t k = 0; k < errors.frame_errors_m.size(); ++k) {
      row.emplace_back(1000 * errors.frame_errors_m[k]);
      if (std::isfinite(errors.frame_errors_m[k]))
        series.points.push_back({double(k), 1000 * errors.frame_errors_m[k]});
    }
    row.emplace_back(1000 * errors.shared_m);
    row.emplace_back(1000 * errors.residual_m);
    table.rows.push_back(row);
    table.chart.series.push_back(series);
    if (options.progress)
      options.progress(0.5 + 0.5 * double(table.rows.size()) /
                                 double(compared.cameras.size()));
  }
  return table;
}

}  // namespace raygrid
