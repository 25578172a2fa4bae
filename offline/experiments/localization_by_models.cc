#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "experiments/calibrated_cameras.h"
#include "initialization/localization.h"
#include "simulation/random.h"

namespace raygrid {
namespace {

// Paper, "Camera Localization": 15 random pixels, 1.5 to 2.5 m away.
constexpr int kPoints = 15, kScenes = 100;
constexpr double kNearM = 1.5, kFarM = 2.5, kNoisePx = 0.05;
constexpr int kNumFrames[] = {1, 4, 16, 64};
constexpr int kMaxFrames = 64;

const ModelChoice kLocalizedModels[] = {{"opencv", 0},
                                        {"thin-prism-fisheye", 0},
                                        {"central-radial", 0},
                                        {"central-generic", 16}};

// Points in the true camera's frame, which stands at the origin.
std::vector<PointOnPixel> MakeScene(const CameraModel& truth, const Area& area,
                                    Random* random) {
  std::vector<PointOnPixel> scene;
  while (static_cast<int>(scene.size()) < kPoints) {
    const double x = random->Uniform(area.x0 + 1, area.x1 - 1);
    const Eigen::Vector2d pixel(x, random->Uniform(area.y0 + 1, area.y1 - 1));
    const double distance_m = random->Uniform(kNearM, kFarM);
    if (const auto line = truth.Line(pixel))
      scene.push_back({line->origin + distance_m * line->direction, pixel});
  }
  return scene;
}

// The errors by number of frames averaged: how far the camera's place is from
// the truth.
using ErrorsM = std::vector<double>;

ErrorsM LocalizeScene(const CameraModel& camera,
                      const std::vector<PointOnPixel>& scene, uint64_t seed) {
  Random random(seed);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  ErrorsM errors;
  for (int frame = 1; frame <= kMaxFrames; ++frame) {
    std::vector<PointOnPixel> seen = scene;
    for (PointOnPixel& match : seen) {
      match.pixel.x() += kNoisePx * random.Normal();
      match.pixel.y() += kNoisePx * random.Normal();
    }
    if (const auto pose = Localize(camera, seen)) {
      sum += pose->Inverse().translation;
      ++count;
    }
    if (std::find(std::begin(kNumFrames), std::end(kNumFrames), frame) !=
        std::end(kNumFrames))
      errors.push_back(count > 0 ? (sum / count).norm() : NAN);
  }
  return errors;
}

// Medians over scenes, by number of frames.
std::vector<double> MedianErrors(const CameraModel& camera,
                                 const CameraModel& truth, const Area& area,
                                 const ExperimentOptions& options) {
  std::vector<ErrorsM> scenes(kScenes);
  ParallelFor(kScenes, NumThreads(options.num_threads), [&](int i) {
    Random random(options.seed * 1000003 + i + 1);
    const std::vector<PointOnPixel> scene = MakeScene(truth, area, &random);
    scenes[i] = LocalizeScene(camera, scene, options.seed * 7919 + i + 1);
  });
  std::vector<double> medians;
  for (size_t k = 0; k < std::size(kNumFrames); ++k) {
    std::vector<double> errors;
    for (const ErrorsM& scene : scenes)
      if (std::isfinite(scene[k])) errors.push_back(scene[k]);
    medians.push_back(Quantile(errors, 0.5));
  }
  return medians;
}

}  // namespace

ExperimentResult LocalizeByModels(const ExperimentOptions& options) {
  const ExperimentFeatures features = FeaturesFor(options);
  ExperimentResult table;
  table.conditions = features.conditions;
  std::vector<NamedCamera> cameras;
  for (const ModelChoice& choice : kLocalizedModels) {
    try {
      cameras.push_back(
          {choice.model,
           CalibrateModel(features, choice, options).camera.camera});
    } catch (const Error& error) {
      table.conditions.push_back({choice.Label(), error.what()});
    }
    if (options.progress) options.progress(0.2 * double(cameras.size()));
  }
  if (cameras.empty())
    throw Error(ExitCode::kInitialization, "no model could be calibrated");
  std::shared_ptr<const CameraModel> truth = features.truth;
  if (truth) {
    cameras.push_back({"truth", truth});
  } else {
    truth = cameras.back().model;
    cameras.back().name += " (the truth here)";
  }
  table.conditions.push_back(
      {"scenes", fmt::format("{} of {} points at random pixels, {:g} to {:g} m "
                             "away, noise {:g} px in an axis",
                             kScenes, kPoints, kNearM, kFarM, kNoisePx)});
  table.columns = {"camera"};
  table.chart.title = "Error of the camera's place";
  table.chart.note =
      "median over scenes; noise averages out, a wrong camera does not";
  table.chart.x_label = "images averaged";
  table.chart.y_label = "error, mm";
  table.chart.is_logarithmic = true;
  for (const int frames : kNumFrames) {
    table.columns.push_back(fmt::format("mean_of_{}_mm", frames));
    table.chart.ticks.push_back(
        {double(table.chart.ticks.size()), std::to_string(frames)});
  }
  const Area area = CommonArea(cameras);
  for (const NamedCamera& camera : cameras) {
    const std::vector<double> medians =
        MedianErrors(*camera.model, *truth, area, options);
    std::vector<Cell> row;
    row.emplace_back(camera.name);
    ChartSeries series = {camera.name, {}, true};
    for (size_t k = 0; k < medians.size(); ++k) {
      row.emplace_back(1000 * medians[k]);
      series.points.push_back({double(k), 1000 * medians[k]});
    }
    table.rows.push_back(row);
    table.chart.series.push_back(series);
  }
  return table;
}

}  // namespace raygrid
