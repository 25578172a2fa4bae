#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <mutex>

#include "calibration/calibration.h"
#include "calibration/calibration_problem.h"
#include "calibration/camera_evaluation.h"
#include "dataset/error.h"
#include "dataset/kinds/star.h"
#include "dataset/parallel_for.h"
#include "evaluation/model_difference.h"
#include "evaluation/residual_statistics.h"
#include "experiments/experiment.h"
#include "features/refinement/camera_refinement.h"
#include "features/refinement/feature_refinement.h"
#include "simulation/image_rendering.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

constexpr char kBiasCamera[] = "fisheye";
constexpr int kWindows[] = {11, 15, 21, 31};
constexpr int kNumWindows = 4;
constexpr int kBiasColumns = 14, kBiasRows = 10;
constexpr double kBiasSquareM = 0.02;

// The refinement methods: without and with the curvature of the mapping within
// the window.
enum MappingKind { kHomography, kCurved, kNumMappingKinds };

Board MakeBoard() {
  StarBoardOptions options;
  options.columns = kBiasColumns;
  options.rows = kBiasRows;
  options.square_mm = kBiasSquareM * 1000;
  Board board = StarBoards(options)[0];
  board.points = board.NominalPoints();
  return board;
}

// Returns the homography whose second derivatives best approximate those of the
// mapping: A s (1 - h s) instead of A s + W (u^2, u v, v^2).
LocalMapping ApproximateByHomography(LocalMapping mapping) {
  const Eigen::Matrix<double, 2, 3> bend =
      mapping.linear.inverse() * mapping.curvature.leftCols<3>();
  mapping.perspective -=
      Eigen::Vector2d(bend(0, 0) + bend(1, 1), bend(0, 1) + bend(1, 2)) / 2;
  mapping.curvature.setZero();
  return mapping;
}

// Features of an image by method and window, in the order of the truth.
struct Measured {
  std::vector<Feature> truth;
  std::vector<std::vector<Feature>> found;  // by method, then by window size
};

class ImageSimulator {
 public:
  ImageSimulator(const CameraModel& camera, const ExperimentOptions& options)
      : camera_(camera),
        options_(options),
        board_(MakeBoard()),
        surface_(board_),
        rays_(camera, NumThreads(options.num_threads)) {
    for (const int window : kWindows) {
      DetectionOptions detection;
      detection.window_px = window;
      refiners_.push_back(std::make_unique<FeatureRefiner>(board_, detection));
    }
  }

  const Board& board() const { return board_; }

  // Refines features with curvature, and from the same initial positions
  // without it.
  Measured RenderView(const Pose& pose, int number) const {
    ImagingOptions imaging;
    imaging.blur_px = options_.blur_px;
    imaging.read_noise = options_.read_noise;
    imaging.seed = options_.seed * 1000003 + number;
    const GreyImage image = MakeGreyImage(AddNoiseAndQuantize(
        RenderImage(rays_, {{&surface_, pose}}, imaging, 1), imaging));
    Measured measured;
    for (const Feature& feature : VisibleFeatures(camera_, board_, pose))
      if (WholeImage(options_.size).Contains(feature.pixel, -kMarginPx))
        measured.truth.push_back(feature);
    for (int way = 0; way < kNumMappingKinds; ++way)
      for (int w = 0; w < kNumWindows; ++w)
        measured.found.push_back(refiners_[w]->RefineWith(
            image, measured.truth, [&](const Feature& feature) {
              auto mapping = ComputeCameraMapping(camera_, pose, board_,
                                                  feature, kWindows[w]);
              if (mapping && way == kHomography)
                mapping = ApproximateByHomography(*mapping);
              return mapping;
            }));
    return measured;
  }

 private:
  static constexpr double kMarginPx = 18;  // half the maximum window + margin

  const CameraModel& camera_;
  const ExperimentOptions& options_;
  Board board_;
  BoardSurface surface_;
  PixelRays rays_;
  std::vector<std::unique_ptr<FeatureRefiner>> refiners_;
};

std::vector<Pose> ChoosePoses(const CameraModel& camera, const Board& board,
                              const ExperimentOptions& options) {
  constexpr int kMinFeatures = 60;
  PoseOptions poses;
  poses.min_square_px = 22;
  poses.max_square_px = 34;
  const Eigen::Vector3d center =
      Eigen::Vector3d(kBiasColumns - 1, kBiasRows - 1, 0) * (kBiasSquareM / 2);
  std::vector<Pose> chosen;
  for (const Pose& pose :
       RandomPoses(camera, center, kBiasSquareM, 20 * options.num_images, poses,
                   options.seed))
    if (static_cast<int>(chosen.size()) < options.num_images &&
        VisibleFeatures(camera, board, pose).size() >= kMinFeatures)
      chosen.push_back(pose);
  if (chosen.size() < 5)
    throw Error(
        ExitCode::kUsage,
        "--size: images are too small for the board; use at least 640x480");
  return chosen;
}

struct Outcome {
  double feature_error_px = 0, residual_px = 0, ray_error_px = 0;
};

// Returns the RMS distance of features from their true positions.
double FeatureErrorPx(const std::vector<Measured>& images, size_t kind) {
  double sum = 0;
  int count = 0;
  for (const Measured& image : images) {
    for (size_t i = 0; i < image.truth.size(); ++i, ++count)
      sum += (image.found[kind][i].pixel - image.truth[i].pixel).squaredNorm();
  }
  return std::sqrt(sum / std::max(1, count));
}

Outcome Evaluate(const CameraModel& camera, const Board& board,
                 const std::vector<Measured>& images, size_t kind,
                 const ExperimentOptions& options) {
  constexpr int kCells = 12;
  constexpr double kStepPx = 8;
  Dataset dataset;
  dataset.image_size = options.size;
  for (size_t i = 0; i < images.size(); ++i)
    dataset.images.push_back(
        {fmt::format("{:03}.png", i), images[i].found[kind]});
  CalibrationOptions calibration;
  calibration.knot_spacing_px =
      double(std::max(options.size.width, options.size.height)) / kCells;
  calibration.fix_target_geometry = true;
  calibration.hold_out = {dataset.images.back().image};
  calibration.num_threads = options.num_threads;
  const CalibrationResult result =
      Calibrate(dataset, Pattern{{board}, ""}, calibration);
  return {FeatureErrorPx(images, kind), result.camera.training->rms_px,
          CompareModels(camera, *result.camera.camera, kStepPx).rms_px};
}

// ---- A user's images -------------------------------------------------------

struct Photograph {
  std::string path;
  ImageFeatures features;
  std::map<int, Pose> poses;  // by board
};

// Returns the images of the given features, with the poses of the boards in
// them.
std::vector<Photograph> SelectPhotographs(const ExperimentOptions& options) {
  const ExperimentData& data = options.data;
  std::map<std::string, Photograph> by_name;
  for (const std::string& path : FindImages(data.images).paths)
    by_name[std::filesystem::path(path).filename().string()].path = path;
  std::vector<RejectedImage> rejected;
  const CalibrationProblem problem =
      BuildProblem({*data.features}, data.pattern, &rejected);
  const auto poses = LocalizeViews(*data.cameras.front().model, 0, problem,
                                   options.num_threads);
  for (size_t v = 0; v < poses.size(); ++v) {
    const auto found = by_name.find(problem.images[v]);
    if (!poses[v] || found == by_name.end()) continue;
    const Board& board = data.pattern.boards[problem.boards[v]];
    found->second.poses[board.id] = *poses[v];
  }
  for (const ImageFeatures& features : data.features->images) {
    const auto found = by_name.find(features.image);
    if (found != by_name.end()) found->second.features = features;
  }
  std::vector<Photograph> photographs;
  for (auto& [name, photograph] : by_name)
    if (!photograph.poses.empty()) photographs.push_back(std::move(photograph));
  if (photographs.empty())
    throw Error(ExitCode::kInsufficientData,
                "--image: no pose could be estimated; check that the image "
                "names match those of the features");
  return photographs;
}

// Features of one window, refined by each method.
struct ShiftedFeatures {
  Dataset measured[kNumMappingKinds];
  double shift_rms_px = 0, shift_max_px = 0;
  int count = 0;
};

ImageFeatures RefineInPhotograph(const GreyImage& image,
                                 const Photograph& photograph,
                                 const CameraModel& camera, const Board& board,
                                 const FeatureRefiner& refiner, int window,
                                 int way) {
  std::vector<Feature> own;
  for (const Feature& feature : photograph.features.features)
    if (feature.board == board.id) own.push_back(feature);
  const Pose& pose = photograph.poses.at(board.id);
  return {photograph.features.image,
          refiner.RefineWith(image, own, [&](const Feature& feature) {
            auto mapping =
                ComputeCameraMapping(camera, pose, board, feature, window);
            if (mapping && way == kHomography)
              mapping = ApproximateByHomography(*mapping);
            return mapping;
          })};
}

ShiftedFeatures MeasureShift(const std::vector<Photograph>& photographs,
                             int window, const ExperimentOptions& options) {
  const CameraModel& camera = *options.data.cameras.front().model;
  DetectionOptions detection;
  detection.window_px = window;
  std::map<int, std::unique_ptr<FeatureRefiner>> refiners;
  for (const Board& board : options.data.pattern.boards)
    refiners[board.id] = std::make_unique<FeatureRefiner>(board, detection);
  const int count = static_cast<int>(photographs.size());
  std::vector<ImageFeatures> measured[kNumMappingKinds];
  for (auto& images : measured) images.resize(count);
  ParallelFor(count, NumThreads(options.num_threads), [&](int i) {
    const Photograph& photograph = photographs[i];
    const GreyImage image = MakeGreyImage(ReadGreyLevels(photograph.path));
    for (int way = 0; way < kNumMappingKinds; ++way) {
      measured[way][i].image = photograph.features.image;
      for (const auto& [id, pose] : photograph.poses) {
        const ImageFeatures again = RefineInPhotograph(
            image, photograph, camera, *options.data.pattern.FindBoard(id),
            *refiners.at(id), window, way);
        measured[way][i].features.insert(measured[way][i].features.end(),
                                         again.features.begin(),
                                         again.features.end());
      }
    }
  });
  ShiftedFeatures shifted;
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    for (size_t k = 0; k < measured[kCurved][i].features.size(); ++k) {
      const double squared = (measured[kCurved][i].features[k].pixel -
                              measured[kHomography][i].features[k].pixel)
                                 .squaredNorm();
      sum += squared;
      shifted.shift_max_px = std::max(shifted.shift_max_px, std::sqrt(squared));
      ++shifted.count;
    }
  }
  shifted.shift_rms_px = std::sqrt(sum / std::max(1, shifted.count));
  for (int way = 0; way < kNumMappingKinds; ++way) {
    shifted.measured[way].image_size = camera.image_size();
    shifted.measured[way].images = std::move(measured[way]);
  }
  return shifted;
}

ExperimentResult MeasureShiftOnUserImages(const ExperimentOptions& options) {
  const ExperimentData& data = options.data;
  if (!data.features || data.images.empty() || data.cameras.size() != 1)
    throw Error(ExitCode::kUsage,
                "curvature-bias: own data requires --image, --features, "
                "--pattern and one --camera");
  const CameraModel& camera = *data.cameras.front().model;
  if (camera.image_size() != data.features->image_size)
    throw InputError(data.cameras.front().name +
                     ": its image size differs from --image-size");
  const std::vector<Photograph> photographs = SelectPhotographs(options);
  ExperimentResult table;
  table.conditions = {
      {"images",
       fmt::format("{} own images, {} x {} px", photographs.size(),
                   camera.image_size().width, camera.image_size().height)},
      {"camera", data.cameras.front().name + ", " + camera.Name()},
      {"shift",
       "of features refined with the camera model, relative to those refined "
       "with a homography per window"},
      {"residuals", "after pose estimation with the camera, for both"}};
  table.columns = {"window_px",
                   "features",
                   "shift_rms_px",
                   "shift_max_px",
                   "residual_rms_homography_px",
                   "residual_rms_curved_px"};
  table.chart.title = "Feature bias from distortion within the window";
  table.chart.note = fmt::format(
      "{} images, RMS; residuals of a camera calibrated from biased features "
      "do not show the bias",
      photographs.size());
  table.chart.x_label = "window, px";
  table.chart.y_label = "bias and residual, px";
  table.chart.is_logarithmic = true;
  ChartSeries shift = {"feature bias", {}, true},
              without = {"residual, homography", {}, true},
              with = {"residual, curved", {}, true};
  for (int w = 0; w < kNumWindows; ++w) {
    const ShiftedFeatures shifted =
        MeasureShift(photographs, kWindows[w], options);
    double rms_px[kNumMappingKinds];
    for (int way = 0; way < kNumMappingKinds; ++way)
      rms_px[way] =
          ComputeErrorMetrics(EvaluateCamera(camera, shifted.measured[way],
                                             data.pattern, options.num_threads)
                                  .residuals)
              .rms_px;
    table.rows.push_back({kWindows[w], shifted.count, shifted.shift_rms_px,
                          shifted.shift_max_px, rms_px[kHomography],
                          rms_px[kCurved]});
    table.chart.ticks.push_back({double(w), std::to_string(kWindows[w])});
    shift.points.push_back({double(w), shifted.shift_rms_px});
    without.points.push_back({double(w), rms_px[kHomography]});
    with.points.push_back({double(w), rms_px[kCurved]});
    if (options.progress) options.progress((w + 1.0) / kNumWindows);
  }
  table.chart.series = {shift, without, with};
  return table;
}

}  // namespace

ExperimentResult MeasureCurvatureBias(const ExperimentOptions& options) {
  if (options.data.features || !options.data.images.empty() ||
      !options.data.cameras.empty())
    return MeasureShiftOnUserImages(options);
  const auto camera = MakeSimulatedCamera(kBiasCamera, options.size);
  const ImageSimulator photographer(*camera, options);
  const std::vector<Pose> poses =
      ChoosePoses(*camera, photographer.board(), options);
  const int count = static_cast<int>(poses.size());
  std::vector<Measured> images(count);
  std::mutex mutex;
  int num_done = 0;
  ParallelFor(count, NumThreads(options.num_threads), [&](int i) {
    images[i] = photographer.RenderView(poses[i], i);
    const std::lock_guard<std::mutex> lock(mutex);
    if (options.progress) options.progress(0.6 * ++num_done / count);
  });

  ExperimentResult table;
  table.conditions = {
      {"images", fmt::format("{} of {} x {} px, rendered", count,
                             options.size.width, options.size.height)},
      {"lens", fmt::format("{}, 145 degrees", kBiasCamera)},
      {"board", fmt::format("{} x {} stars, squares of 22 to 34 px",
                            kBiasColumns, kBiasRows)},
      {"blur", fmt::format("{:g} px (1 sigma)", options.blur_px)},
      {"noise", fmt::format("{:g} grey levels (1 sigma)", options.read_noise)},
      {"camera", "central-generic, 12 knots along the longer side"},
      {"seed", std::to_string(options.seed)}};
  table.columns = {"mapping", "window_px", "feature_error_rms_px",
                   "residual_rms_px", "ray_error_rms_px"};
  table.chart.title = "Bias of symmetry refinement for a fisheye camera";
  table.chart.note =
      fmt::format("{} images, RMS; residuals do not show the ray error", count);
  table.chart.x_label = "window, px";
  table.chart.y_label = "ray error and residual, px";
  table.chart.is_logarithmic = true;
  const char* names[] = {"homography", "curved"};
  for (const int window : kWindows)
    table.chart.ticks.push_back(
        {double(table.chart.ticks.size()), std::to_string(window)});
  for (int way = 0; way < kNumMappingKinds; ++way) {
    ChartSeries rays = {std::string("ray error, ") + names[way], {}, true};
    ChartSeries residuals = {std::string("residual, ") + names[way], {}, true};
    for (int w = 0; w < kNumWindows; ++w) {
      const Outcome outcome = Evaluate(*camera, photographer.board(), images,
                                       way * kNumWindows + w, options);
      table.rows.push_back({std::string(names[way]), kWindows[w],
                            outcome.feature_error_px, outcome.residual_px,
                            outcome.ray_error_px});
      rays.points.push_back({double(w), outcome.ray_error_px});
      residuals.points.push_back({double(w), outcome.residual_px});
      if (options.progress)
        options.progress(0.6 + 0.4 * (way * kNumWindows + w + 1) /
                                   (kNumMappingKinds * kNumWindows));
    }
    table.chart.series.push_back(rays);
    table.chart.series.push_back(residuals);
  }
  return table;
}

}  // namespace raygrid
