#include "experiments/fine_validation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "calibration/camera_evaluation.h"
#include "calibration/camera_initialization.h"
#include "calibration/camera_result.h"
#include "calibration/model_adjustment.h"
#include "camera/model_registry.h"
#include "dataset/error.h"
#include "dataset/kinds/star.h"
#include "dataset/parallel_for.h"
#include "evaluation/model_difference.h"
#include "experiments/montage.h"
#include "report/plots.h"
#include "simulation/bumpy_camera.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

constexpr double kBumpHeightPx = 0.2;
constexpr double kFinePupilShiftM = 2e-4;  // at 1 rad off axis
constexpr double kFineNoisePx = 0.03;      // per coordinate
constexpr int kMaxFeatures = 1050;         // per image
constexpr int kTestEvery = 5;

struct FineModel {
  std::string name;
  double knot_spacing_px;  // 0 for a parametric model

  std::string Label() const {
    return knot_spacing_px > 0 ? fmt::format("{}/{:g}", name, knot_spacing_px)
                               : name;
  }
};

std::vector<FineModel> ListFineModels() {
  std::vector<FineModel> models;
  for (const std::string& name : ListModelNames(ModelUse::kCompare))
    models.push_back({name, 0});
  for (const char* name : {models::kCentralGeneric, models::kNonCentralGeneric})
    for (const double knot_spacing_px : {30, 20, 10})
      models.push_back({name, knot_spacing_px});
  return models;
}

// Returns a lens with a horizontal field of view of 62 degrees and barrel
// distortion.
BumpyCamera MakeFineBumpsCamera(const ImageSize& size, double bump_width_px,
                                uint64_t seed) {
  constexpr double kMarginPx = 50;
  const Area area = {-1, -1, double(size.width), double(size.height)};
  const double f_px = 0.83 * size.width;
  const OpenCvModel lens(
      size,
      {area.x0 - kMarginPx, area.y0 - kMarginPx, area.x1 + kMarginPx,
       area.y1 + kMarginPx},
      {f_px, 1.002 * f_px, size.width * 0.503 - 0.5, size.height * 0.495 - 0.5,
       -0.28, 0.09, 0, 0, 0, 0, 7e-4, -4e-4});
  return BumpyCamera(lens, area,
                     {bump_width_px, kBumpHeightPx, kFinePupilShiftM, seed});
}

Pattern FineBoard() {
  StarBoardOptions options;
  options.columns = 60;
  options.rows = 44;
  options.square_mm = 12;
  Pattern pattern;
  pattern.boards = StarBoards(options);
  for (Board& board : pattern.boards) board.points = board.NominalPoints();
  return pattern;
}

bool IsInImageCorner(const Eigen::Vector2d& pixel, const ImageSize& size) {
  constexpr double kPart = 0.1;  // fraction of each side
  const auto is_at_an_end = [](double position, double extent) {
    return std::min(position, extent - position) < kPart * extent;
  };
  return is_at_an_end(pixel.x(), size.width) &&
         is_at_an_end(pixel.y(), size.height);
}

// Returns the features of a board in a random pose, in which any of its points
// may project to any pixel.
std::vector<Feature> FineFeatures(const CameraModel& camera, const Board& board,
                                  uint64_t seed) {
  Random random(seed);
  const double x = random.Uniform(0, board.columns - 1);
  const double y = random.Uniform(0, board.rows - 1);
  const Pose pose =
      RandomPoses(camera, board.square_m * Eigen::Vector3d(x, y, 0),
                  board.square_m, 1, {}, seed)
          .front();
  std::vector<Feature> seen = VisibleFeatures(camera, board, pose);
  // Fewer boards extend into the corners: therefore, all features there are
  // used, and other features with the probability that yields the required
  // number.
  const auto others = std::stable_partition(
      seen.begin(), seen.end(), [&camera](const Feature& feature) {
        return IsInImageCorner(feature.pixel, camera.image_size());
      });
  std::vector<Feature> training_features(seen.begin(), others);
  int num_left = static_cast<int>(seen.end() - others);
  for (auto feature = others; feature != seen.end(); ++feature) {
    const int num_wanted =
        kMaxFeatures - static_cast<int>(training_features.size());
    if (random.Uniform(0, num_left--) < num_wanted)
      training_features.push_back(*feature);
  }
  SimulationOptions noise;
  noise.noise_px = kFineNoisePx;
  AddNoise(noise, &random, &training_features);
  return training_features;
}

// Images for calibration, and held-out images.
struct FineImages {
  Dataset training, test;
};

FineImages SimulateFineImages(const CameraModel& camera, const Board& board,
                              const ExperimentOptions& options) {
  std::vector<ImageFeatures> images(options.num_images);
  ParallelFor(options.num_images, NumThreads(options.num_threads), [&](int i) {
    images[i] = {fmt::format("sim{:04d}.png", i),
                 FineFeatures(camera, board, options.seed * 100000 + i + 1)};
  });
  FineImages split;
  split.training.image_size = split.test.image_size = camera.image_size();
  for (size_t i = 0; i < images.size(); ++i)
    (i % kTestEvery == kTestEvery - 1 ? split.test : split.training)
        .images.push_back(std::move(images[i]));
  if (split.test.images.empty())
    throw Error(ExitCode::kInsufficientData,
                "too few images to hold some out; use at least five");
  return split;
}

// Returns the minimum number of residuals in a cell of the bias's grid.
int ComputeMinCellCount(const std::vector<FeatureResidual>& residuals,
                        const Area& area) {
  std::vector<int> counts(kBiasCells * kBiasCells);
  const auto cell_of = [](double position, double start, double extent) {
    return std::clamp(
        static_cast<int>((position - start) / extent * kBiasCells), 0,
        kBiasCells - 1);
  };
  for (const FeatureResidual& residual : residuals)
    ++counts[cell_of(residual.pixel.y(), area.y0, area.height()) * kBiasCells +
             cell_of(residual.pixel.x(), area.x0, area.width())];
  return *std::min_element(counts.begin(), counts.end());
}

struct FineMetrics {
  double test_px = 0;
  std::optional<double> bias;
  std::vector<FeatureResidual> training;
};

// Optimizes the model like calibrate, from the initial camera, with estimated
// target points.
FineMetrics AddFineRow(const FineModel& model, const CameraModel& truth,
                       const FineImages& images, const Pattern& pattern,
                       const AdjustmentResult& start, double bump_width_px,
                       const ExperimentOptions& options,
                       ExperimentResult* table) {
  AdjustmentOptions adjustment;
  adjustment.num_threads = NumThreads(options.num_threads);
  AdjustmentResult adjusted = start;
  OptimizeModel(pattern, model.name, {model.knot_spacing_px}, adjustment,
                &adjusted);
  AlignBoards(pattern, &adjusted);
  const CameraModel& camera = adjusted.state.camera();
  FineMetrics metrics;
  metrics.training =
      ComputeTrainingResiduals(pattern, adjusted, 0, options.num_threads);
  metrics.test_px = ComputeErrorMetrics(
                        EvaluateCamera(camera, images.test,
                                       MakeEstimatedPattern(pattern, adjusted),
                                       options.num_threads)
                            .residuals)
                        .median_px;
  metrics.bias = ComputeBias(metrics.training, camera.area());
  const auto noise_bias = ComputeNoiseBias(metrics.training, camera.area());
  constexpr double kStepPx = 5;
  const ModelDifference difference = CompareModels(truth, camera, kStepPx);
  const auto or_dash = [](const std::optional<double>& number) {
    return number ? Cell(*number) : Cell(std::string("-"));
  };
  table->rows.push_back(
      {static_cast<int>(bump_width_px), model.name,
       static_cast<int>(model.knot_spacing_px), camera.NumParameters(),
       ComputeErrorMetrics(metrics.training).median_px, metrics.test_px,
       or_dash(metrics.bias), or_dash(noise_bias),
       ComputeMinCellCount(metrics.training, camera.area()),
       difference.median_px, difference.rms_px});
  return metrics;
}

// Returns a label short enough for a picture's caption.
std::string FormatCaption(const FineModel& model, const FineMetrics& metrics) {
  std::string label = model.Label();
  const size_t generic = label.find("-generic");
  if (generic != std::string::npos) label.erase(generic, 8);
  const std::string bias =
      metrics.bias ? fmt::format(", bias {:.3f}", *metrics.bias) : "";
  return fmt::format("{}: test {:.3g} px{}", label, metrics.test_px, bias);
}

std::vector<Condition> ListFineConditions(const ExperimentOptions& options) {
  return {
      {"images", fmt::format("{} of {} x {} px, every fifth held out; a star "
                             "board, up to {} features each",
                             options.num_images, options.size.width,
                             options.size.height, kMaxFeatures)},
      {"features", "simulated, not detected in rendered images"},
      {"noise", fmt::format("{:g} px per axis", kFineNoisePx)},
      {"lens",
       fmt::format(
           "62 degrees, with local distortion of {:g} px, width (at half "
           "height) as in the table; the pupil moves by {:g} mm at one radian",
           kBumpHeightPx, 1e3 * kFinePupilShiftM)},
      {"calibrated", "target geometry estimated, knot spacing as in the table"},
      {"seed", std::to_string(options.seed)}};
}

ExperimentResult EmptyFineTable(const ExperimentOptions& options) {
  ExperimentResult table;
  table.conditions = ListFineConditions(options);
  table.columns = {"bump_px",
                   "model",
                   "cell_px",
                   "parameters",
                   "training_median_px",
                   "test_median_px",
                   "bias_kl",
                   "noise_bias_kl",
                   "fewest_in_a_cell",
                   "ray_error_px",
                   "ray_rms_px"};
  table.chart.title = "Held-out error by model and width of local distortion";
  table.chart.note =
      "median over features; c: central-generic, n: noncentral-generic, with "
      "knot spacing in px";
  table.chart.x_label = "model";
  table.chart.y_label = "median error, px";
  table.chart.is_logarithmic = true;
  for (const FineModel& model : ListFineModels())
    table.chart.ticks.push_back(
        {double(table.chart.ticks.size()),
         model.knot_spacing_px > 0
             ? fmt::format("{}/{:g}", model.name[0], model.knot_spacing_px)
             : model.name});
  return table;
}

}  // namespace

ExperimentResult ValidateFineModels(const ExperimentOptions& options) {
  ExperimentResult table = EmptyFineTable(options);
  const Pattern pattern = FineBoard();
  const Image wheel = DrawDirectionLegend(96);
  const std::vector<FineModel> models = ListFineModels();
  int num_done = 0;
  for (const double width_px : options.bump_widths_px) {
    const BumpyCamera truth =
        MakeFineBumpsCamera(options.size, width_px, options.seed);
    const FineImages images =
        SimulateFineImages(truth, pattern.boards.front(), options);
    table.conditions.push_back(
        {fmt::format("features, local distortion {:g} px", width_px),
         fmt::format("{} for calibration, {} for testing",
                     images.training.num_features(),
                     images.test.num_features())});
    AdjustmentOptions adjustment;
    adjustment.num_threads = NumThreads(options.num_threads);
    const AdjustmentResult start =
        InitializeCamera(images.training, pattern, adjustment);
    ChartSeries series = {
        fmt::format("local distortion {:g} px wide", width_px), {}, false};
    std::vector<MontageImage> pictures;
    for (size_t i = 0; i < models.size(); ++i) {
      const FineModel& model = models[i];
      try {
        const FineMetrics metrics = AddFineRow(
            model, truth, images, pattern, start, width_px, options, &table);
        series.points.push_back({double(i), metrics.test_px});
        pictures.push_back({FormatCaption(model, metrics),
                            DrawDirectionPlot(metrics.training, options.size,
                                              WholeImage(options.size))});
      } catch (const Error& error) {
        table.conditions.push_back({fmt::format("{}, local distortion {:g} px",
                                                model.Label(), width_px),
                                    error.what()});
      }
      if (options.progress)
        options.progress(double(++num_done) /
                         double(models.size() * options.bump_widths_px.size()));
    }
    if (pictures.empty())
      throw Error(ExitCode::kInitializationFailed,
                  "no model could be calibrated");
    table.chart.series.push_back(std::move(series));
    table.pictures.push_back(
        {fmt::format("directions-{:g}px", width_px),
         ComposeMontage(
             pictures,
             {fmt::format(
                  "Local distortion {:g} px wide. Direction of the nearest",
                  width_px),
              "training residual (projected - observed), by the",
              "colours of the wheel. Patches: model error."},
             &wheel)});
  }
  return table;
}

}  // namespace raygrid
