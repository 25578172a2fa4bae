#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <mutex>

#include "camera/thin_prism_fisheye.h"
#include "capture/live_camera.h"
#include "capture/next_view.h"
#include "dataset/parallel_for.h"
#include "evaluation/model_difference.h"
#include "evaluation/residual_statistics.h"
#include "experiments/experiment.h"
#include "simulation/random.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

constexpr double kTargetPx = 0.02;
constexpr double kFeatureNoisePx = 0.05;
constexpr int kMaxImages = 200;
// From kMinImagesForSparseEvaluation images on, the camera is evaluated only
// after every kEvaluationInterval images, unless the next view depends on it.
constexpr int kMinImagesForSparseEvaluation = 80, kEvaluationInterval = 10;
constexpr double kOperatorErrorM = 0.03,
                 kOperatorErrorRad = 5 * M_PI / 180;  // operator's error

// Horizontal fields of view from 50 to 140 degrees, with an offset principal
// point.
ThinPrismFisheye MakeRandomCamera(const ImageSize& size, uint64_t seed) {
  Random random(seed);
  const double half_rad = random.Uniform(25, 70) * M_PI / 180;
  const double k1 = random.Uniform(-0.08, 0.04);
  const double k2 = random.Uniform(-0.01, 0.01);
  const double g = 1 + k1 * std::pow(half_rad, 2) + k2 * std::pow(half_rad, 4);
  const double f_px = size.width / 2.0 / (half_rad * g);
  const double shift_px = 0.02 * size.width;
  const double cx =
      (size.width - 1) / 2.0 + random.Uniform(-shift_px, shift_px);
  const double cy =
      (size.height - 1) / 2.0 + random.Uniform(-shift_px, shift_px);
  const Area area = {-1, -1, double(size.width), double(size.height)};
  return {size,
          area,
          {f_px, f_px * random.Uniform(0.998, 1.002), cx, cy, k1, k2, 0, 0,
           random.Uniform(-5e-4, 5e-4), random.Uniform(-5e-4, 5e-4), 0, 0}};
}

Pattern GuidanceBoard() {
  Board board;
  board.kind = "chessboard";
  board.columns = 11;
  board.rows = 8;
  board.square_m = 0.025;
  board.points = board.NominalPoints();
  Pattern pattern;
  pattern.boards = {board};
  return pattern;
}

// Returns a view anywhere in the image, at a random distance, tilt and
// rotation.
BoardView RandomView(const ImageSize& size, Random* random) {
  BoardView view;
  view.pixel = {random->Uniform(0, size.width),
                random->Uniform(0, size.height)};
  view.width_px = size.width * random->Uniform(0.3, 1.1);
  view.tilt_rad = random->Uniform(0, 50) * M_PI / 180;
  view.axis_rad = random->Uniform(0, 2 * M_PI);
  view.turn_rad = random->Uniform(-M_PI, M_PI);
  return view;
}

// ---- ROS's criteria ---------------------------------------------------------

constexpr int kNumBars = 4;
using Bars = Eigen::Array<double, kNumBars, 1>;

// Returns the position, size and skew of a completely visible board, as in
// ROS's camera_calibration.
Bars ComputeBars(const std::vector<Feature>& features, const Board& board,
                 const ImageSize& size) {
  Eigen::Vector2d corner[4], mean = Eigen::Vector2d::Zero();
  for (const Feature& feature : features) {
    mean += feature.pixel / static_cast<double>(features.size());
    const bool is_right = feature.column == board.columns - 1;
    const bool is_low = feature.row == board.rows - 1;
    if ((is_right || feature.column == 0) && (is_low || feature.row == 0))
      corner[is_low ? (is_right ? 2 : 3) : (is_right ? 1 : 0)] = feature.pixel;
  }
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  const double area =
      std::abs(cross(corner[2] - corner[0], corner[3] - corner[1])) / 2;
  const double border = std::sqrt(area);
  const Eigen::Vector2d a = corner[0] - corner[1], b = corner[2] - corner[1];
  const double angle = std::acos(a.dot(b) / (a.norm() * b.norm()));
  Bars bars;
  bars << std::clamp((mean.x() - border / 2) / (size.width - border), 0.0, 1.0),
      std::clamp((mean.y() - border / 2) / (size.height - border), 0.0, 1.0),
      std::sqrt(area / (double(size.width) * size.height)),
      std::min(1.0, 2 * std::abs(M_PI / 2 - angle));
  return bars;
}

// Returns the sum of the fill levels of the bars.
double ComputeFullness(const std::vector<Bars>& frames) {
  const Bars ranges = {0.7, 0.7, 0.4, 0.5};
  Bars low = frames.front(), high = frames.front();
  for (const Bars& frame : frames) {
    low = low.min(frame);
    high = high.max(frame);
  }
  low.tail<2>().setZero();  // size and skew start at 0
  return ((high - low) / ranges).min(1).sum();
}

// ---- Operators --------------------------------------------------------------

enum class GuidanceMode { kNextView, kBars, kNothing };

constexpr size_t kMinKeptFeatures = 20;  // minimum features of a kept image

struct Operator {
  GuidanceMode guidance_mode;
  const ThinPrismFisheye& truth;
  const Pattern& pattern;
  Random random;
  std::vector<Bars> frames = {};

  const Board& board() const { return pattern.boards.front(); }

  Pose PerturbPose(const Pose& asked) {
    Eigen::Matrix<double, 6, 1> off;
    for (int k = 0; k < 6; ++k)
      off[k] = random.Normal() * (k < 3 ? kOperatorErrorRad : kOperatorErrorM);
    // The operator rotates the board about its centre.
    const Eigen::Vector3d center = ComputeBoardCenter(board());
    Pose held = asked;
    held.rotation = RotationFromVector(off.head<3>()) * asked.rotation;
    held.translation = asked * center - held.rotation * center + off.tail<3>();
    return held;
  }

  // Returns the features detected when the operator attempts a view; few if the
  // attempt fails.
  std::vector<Feature> Try(const BoardView& view) {
    const auto pose = ComputePose(view, board(), truth);
    if (!pose) return {};
    std::vector<Feature> seen =
        VisibleFeatures(truth, board(), PerturbPose(*pose));
    const Area found = GetFeatureArea(truth.image_size());
    seen.erase(std::remove_if(seen.begin(), seen.end(),
                              [&found](const Feature& feature) {
                                return !found.Contains(feature.pixel);
                              }),
               seen.end());
    return seen;
  }

  bool HasAllPoints(const std::vector<Feature>& features) const {
    return static_cast<int>(features.size()) == board().num_points();
  }

  std::vector<Feature> SelectRandomView() {
    for (;;) {
      std::vector<Feature> seen = Try(RandomView(truth.image_size(), &random));
      if (seen.size() >= kMinKeptFeatures) return seen;
    }
  }

  // Returns the one of several random views that fills the bars most; once they
  // are full, any view that ROS accepts as new.
  std::vector<Feature> SelectViewByCoverage() {
    constexpr int kTries = 30;
    constexpr double kNew = 0.2;
    std::vector<Feature> best;
    double best_score = -1;
    Bars best_bars = Bars::Zero();
    for (int k = 0; k < kTries;) {
      std::vector<Feature> seen = SelectRandomView();
      if (!HasAllPoints(seen)) continue;
      ++k;
      const Bars bars = ComputeBars(seen, board(), truth.image_size());
      double nearest = INFINITY;
      for (const Bars& frame : frames)
        nearest = std::min(nearest, (frame - bars).abs().sum());
      std::vector<Bars> with = frames;
      with.push_back(bars);
      const double score = ComputeFullness(with) + (nearest > kNew ? 1 : 0);
      if (score <= best_score) continue;
      best_score = score;
      best = std::move(seen);
      best_bars = bars;
    }
    frames.push_back(best_bars);
    return best;
  }

  std::vector<Feature> SelectNextBestView(const LiveCamera& live) {
    const int index = static_cast<int>(live.images().images.size());
    std::vector<Feature> seen;
    if (live.adjusted()) {
      if (const auto information = CameraInformation::Of(*live.adjusted()))
        if (const auto next = FindBestNextView(*information, board()))
          seen = Try(next->view);
    } else if (index < kNumFirstViews) {
      seen = Try(FirstView(index, truth.image_size()));
    }
    return seen.size() >= kMinKeptFeatures ? seen : SelectRandomView();
  }

  std::vector<Feature> Next(const LiveCamera& live) {
    switch (guidance_mode) {
      case GuidanceMode::kNextView:
        return SelectNextBestView(live);
      case GuidanceMode::kBars:
        return SelectViewByCoverage();
      case GuidanceMode::kNothing:
        break;
    }
    return SelectRandomView();
  }
};

double TrueError95(const CameraModel& truth, const CameraModel& camera) {
  constexpr double kStepPx = 10;
  const ModelDifference difference = CompareModels(truth, camera, kStepPx);
  std::vector<double> norms;
  for (const Eigen::Vector2d& error : difference.error_px)
    norms.push_back(error.norm());
  return norms.empty() ? INFINITY : Quantile(norms, 0.95);
}

// The number of images until the camera reached its target uncertainty (if it
// did), and the uncertainty predicted then.
struct CaptureRun {
  int num_images = 0;
  bool is_done = false;
  double predicted_px = 0;
};

CaptureRun SimulateCapture(GuidanceMode guidance_mode,
                           const ThinPrismFisheye& truth,
                           const Pattern& pattern, uint64_t seed) {
  Operator hand = {guidance_mode, truth, pattern, Random(seed)};
  LiveCamera live(pattern, truth.image_size(), 1);
  SimulationOptions noise;
  noise.noise_px = kFeatureNoisePx;
  CaptureRun capture;
  while (capture.num_images < kMaxImages && !capture.is_done) {
    std::vector<ImageFeatures> images;
    const bool is_each_looked_at =
        capture.num_images < kMinImagesForSparseEvaluation ||
        guidance_mode == GuidanceMode::kNextView;
    const int count = is_each_looked_at ? 1 : kEvaluationInterval;
    for (int k = 0; k < count; ++k) {
      std::vector<Feature> seen = hand.Next(live);
      AddNoise(noise, &hand.random, &seen);
      images.push_back({fmt::format("{:04d}.png", capture.num_images++), seen});
    }
    if (count == 1)
      live.Add(images[0]);
    else
      live.Add(images);
    capture.is_done =
        live.adjusted() &&
        TrueError95(truth, live.adjusted()->state.camera()) <= kTargetPx;
  }
  if (live.adjusted())
    if (const auto information = CameraInformation::Of(*live.adjusted()))
      capture.predicted_px = information->Percentile95Px();
  return capture;
}

constexpr GuidanceMode kOperators[] = {
    GuidanceMode::kNextView, GuidanceMode::kBars, GuidanceMode::kNothing};
constexpr const char* kOperatorNames[] = {"next view", "ROS's bars", "nothing"};
constexpr int kNumOperators = 3;

std::vector<Condition> ListGuidanceConditions(
    const ExperimentOptions& options) {
  return {{"lenses", fmt::format("{}, equidistant with distortion, 50 to 140 "
                                 "degrees across {} x {} px",
                                 options.num_images, options.size.width,
                                 options.size.height)},
          {"board", "11 x 8 features, 25 mm apart"},
          {"features", "at least 11 px from the image border"},
          {"noise", fmt::format("{:g} px per axis", kFeatureNoisePx)},
          {"operator", fmt::format("positions the board with errors of 3 cm "
                                   "and 5 degrees (1 sigma per axis)")},
          {"next view",
           "as in raygrid: largest expected reduction of the mean variance"},
          {"ROS's bars",
           "one of 30 views of the whole board: the one that fills the bars "
           "most, or one that ROS accepts as new"},
          {"nothing",
           "random position, 0.3 to 1.1 times the image width, tilt up to 50 "
           "degrees; boards may be partly visible, as with the next view"},
          {"camera", "16 knots along the longer side"},
          {"until", fmt::format("95 % of the rays are within {:g} px of ground "
                                "truth; at most {} images",
                                kTargetPx, kMaxImages)},
          {"seed", std::to_string(options.seed)}};
}

// Returns the total number of images of the guided operator relative to that of
// another one.
double ComputeImageRatio(const std::vector<CaptureRun>& captures,
                         int follower) {
  double guided = 0, other = 0;
  for (size_t i = 0; i < captures.size(); i += kNumOperators) {
    guided += captures[i].num_images;
    other += captures[i + follower].num_images;
  }
  return guided / other;
}

}  // namespace

ExperimentResult CompareCaptureGuidance(const ExperimentOptions& options) {
  const Pattern pattern = GuidanceBoard();
  const int num_cameras = options.num_images;
  std::vector<CaptureRun> captures(num_cameras * kNumOperators);
  int num_done = 0;
  const auto num_all = static_cast<int>(captures.size());
  std::mutex progress;
  ParallelFor(num_all, NumThreads(options.num_threads), [&](int k) {
    const uint64_t seed = options.seed * 1000 + k / kNumOperators;
    captures[k] =
        SimulateCapture(kOperators[k % kNumOperators],
                        MakeRandomCamera(options.size, seed), pattern, seed);
    const std::lock_guard lock(progress);
    if (options.progress) options.progress(double(++num_done) / num_all);
  });
  ExperimentResult table;
  table.conditions = ListGuidanceConditions(options);
  for (int k = 1; k < kNumOperators; ++k)
    table.conditions.push_back(
        {fmt::format("images, next view to {}", kOperatorNames[k]),
         fmt::format("{:.2f}", ComputeImageRatio(captures, k))});
  table.columns = {"lens", "operator_follows", "images", "is_known",
                   "predicted_px"};
  table.chart.title = "Images until convergence";
  table.chart.note = fmt::format(
      "95 % of the rays within {:g} px; at the top: not converged", kTargetPx);
  table.chart.x_label = "lens";
  table.chart.y_label = "images";
  for (const char* name : kOperatorNames)
    table.chart.series.push_back({name, {}, false});
  for (int k = 0; k < num_all; ++k) {
    const int lens = k / kNumOperators, follower = k % kNumOperators;
    table.rows.push_back({lens, std::string(kOperatorNames[follower]),
                          captures[k].num_images,
                          std::string(captures[k].is_done ? "yes" : "no"),
                          captures[k].predicted_px});
    table.chart.series[follower].points.push_back(
        {double(lens), double(captures[k].num_images)});
    if (follower == 0)
      table.chart.ticks.push_back({double(lens), std::to_string(lens)});
  }
  return table;
}

}  // namespace raygrid
