#include "experiments/localization_error.h"

#include <fmt/format.h>

#include <mutex>
#include <optional>

#include "dataset/error.h"
#include "dataset/kinds/star.h"
#include "dataset/parallel_for.h"
#include "evaluation/residual_statistics.h"
#include "features/pattern_detector.h"
#include "simulation/image_rendering.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

constexpr int kBoardColumns = 12, kBoardRows = 9;
constexpr double kBoardSquareM = 0.012;
constexpr char kBoardCamera[] = "pinhole";
constexpr double kMinSquarePx = 20, kMaxSquarePx = 32, kMaxTiltDeg = 45;
constexpr double kMarginPx = 2;  // between board and image edge

ImagingOptions Imaging(const ExperimentOptions& options, int image) {
  ImagingOptions imaging;
  imaging.blur_px = options.blur_px;
  imaging.read_noise = options.read_noise;
  imaging.seed = options.seed * 1000003 + image;
  return imaging;
}

// The printed pattern extends one square beyond the features.
bool IsFullyVisible(const CameraModel& camera, const Pose& pose) {
  const Area image = WholeImage(camera.image_size());
  for (const double column : {-1, kBoardColumns}) {
    for (const double row : {-1, kBoardRows}) {
      const auto pixel = camera.Project(
          pose * (kBoardSquareM * Eigen::Vector3d(column, row, 0)));
      if (!pixel || !image.Contains(*pixel, -kMarginPx)) return false;
    }
  }
  return true;
}

std::vector<Pose> ChoosePoses(const CameraModel& camera,
                              const ExperimentOptions& options) {
  constexpr int kMaxTries = 200;
  PoseOptions pose_options;
  pose_options.min_square_px = kMinSquarePx;
  pose_options.max_square_px = kMaxSquarePx;
  pose_options.max_tilt_rad = kMaxTiltDeg * M_PI / 180;
  const Eigen::Vector3d center =
      Eigen::Vector3d(kBoardColumns - 1, kBoardRows - 1, 0) *
      (kBoardSquareM / 2);
  std::vector<Pose> chosen;
  for (const Pose& pose :
       RandomPoses(camera, center, kBoardSquareM,
                   kMaxTries * options.num_images, pose_options, options.seed))
    if (static_cast<int>(chosen.size()) < options.num_images &&
        IsFullyVisible(camera, pose))
      chosen.push_back(pose);
  if (static_cast<int>(chosen.size()) < options.num_images)
    throw Error(
        ExitCode::kUsage,
        fmt::format("--size {}x{}: too small for a board of {} x {} features "
                    "with squares of {:g} to {:g} px; use at least 640x480",
                    options.size.width, options.size.height, kBoardColumns,
                    kBoardRows, kMinSquarePx, kMaxSquarePx));
  return chosen;
}

// Detected minus true positions, by PointIndex(); nullopt if the feature was
// not found.
using FeatureErrors = std::vector<std::optional<Eigen::Array2d>>;

FeatureErrors ComputeFeatureErrors(const std::vector<Feature>& found,
                                   const std::vector<Feature>& truth,
                                   const Board& board) {
  FeatureErrors true_pixels(board.num_points()), errors(board.num_points());
  for (const Feature& feature : truth)
    true_pixels[board.PointIndex(feature.column, feature.row)] =
        feature.pixel.array();
  for (const Feature& feature : found) {
    const int index = board.PointIndex(feature.column, feature.row);
    if (true_pixels[index])
      errors[index] = feature.pixel.array() - *true_pixels[index];
  }
  return errors;
}

// A board with its appearance, and a detector for each method.
class BoardTrial {
 public:
  explicit BoardTrial(const DetectedBoard& detected)
      : board_(detected.board), surface_(board_) {
    for (const DetectionOptions& way : detected.ways)
      detectors_.push_back(
          std::make_unique<PatternDetector>(Pattern{{board_}, ""}, way));
  }

  struct Outcome {
    int num_visible = 0;
    std::vector<FeatureErrors> errors;  // by method
  };
  Outcome Run(const CameraModel& camera, const PixelRays& rays,
              const Pose& pose, const ImagingOptions& imaging) const {
    const std::vector<Feature> truth = VisibleFeatures(camera, board_, pose);
    const GreyImage image = MakeGreyImage(AddNoiseAndQuantize(
        RenderImage(rays, {{&surface_, pose}}, imaging, 1), imaging));
    Outcome outcome = {static_cast<int>(truth.size()), {}};
    for (const auto& detector : detectors_)
      outcome.errors.push_back(ComputeFeatureErrors(
          detector->Detect(image).features, truth, board_));
    return outcome;
  }

  size_t num_ways() const { return detectors_.size(); }

 private:
  Board board_;
  BoardSurface surface_;
  std::vector<std::unique_ptr<PatternDetector>> detectors_;
};

// Indexed by trial, then image.
using Outcomes = std::vector<std::vector<BoardTrial::Outcome>>;

Outcomes RunAll(const std::vector<BoardTrial>& trials,
                const ExperimentOptions& options) {
  const auto camera = MakeSimulatedCamera(kBoardCamera, options.size);
  const std::vector<Pose> poses = ChoosePoses(*camera, options);
  const int num_threads = NumThreads(options.num_threads);
  const PixelRays rays(*camera, num_threads);
  const int num_trials = static_cast<int>(trials.size());
  const int count = num_trials * options.num_images;
  Outcomes outcomes(trials.size(),
                    std::vector<BoardTrial::Outcome>(options.num_images));
  std::mutex mutex;
  int num_done = 0;
  ParallelFor(count, num_threads, [&](int i) {
    const int trial = i % num_trials, image = i / num_trials;
    outcomes[trial][image] =
        trials[trial].Run(*camera, rays, poses[image], Imaging(options, image));
    const std::lock_guard<std::mutex> lock(mutex);
    if (options.progress)
      options.progress(static_cast<double>(++num_done) / count);
  });
  return outcomes;
}

bool IsFoundInAll(const Outcomes& outcomes, int image, int index) {
  for (const auto& outcomes_of_board : outcomes)
    for (const FeatureErrors& errors : outcomes_of_board[image].errors)
      if (!errors[index]) return false;
  return true;
}

// For each image, the indices of the features found on all boards by all
// methods.
std::vector<std::vector<int>> FoundInAll(const Outcomes& outcomes,
                                         int num_images) {
  std::vector<std::vector<int>> found(num_images);
  for (int image = 0; image < num_images; ++image)
    for (int index = 0; index < kBoardColumns * kBoardRows; ++index)
      if (IsFoundInAll(outcomes, image, index)) found[image].push_back(index);
  return found;
}

LocalizationError SummarizeCandidate(
    const std::vector<BoardTrial::Outcome>& outcomes_by_image, size_t way,
    const std::vector<std::vector<int>>& compared) {
  LocalizationError summary;
  std::vector<double> absolute[2];
  Eigen::Array2d squares = {0, 0};
  for (size_t image = 0; image < compared.size(); ++image) {
    const BoardTrial::Outcome& outcome = outcomes_by_image[image];
    const FeatureErrors& errors = outcome.errors[way];
    summary.num_visible += outcome.num_visible;
    for (const auto& error : errors) summary.num_found += error.has_value();
    for (const int index : compared[image]) {
      const Eigen::Array2d error = errors[index].value();
      squares += error.square();
      for (int k = 0; k < 2; ++k) absolute[k].push_back(std::abs(error[k]));
      summary.max_error_px =
          std::max(summary.max_error_px, error.matrix().norm());
    }
  }
  summary.num_compared = static_cast<int>(absolute[0].size());
  if (summary.num_compared == 0)
    throw Error(ExitCode::kInsufficientData,
                "no feature was found in all variants; reduce --blur-px or "
                "--read-noise, or use more --images");
  summary.rms_px = (squares / summary.num_compared).sqrt();
  for (int k = 0; k < 2; ++k) summary.median_px[k] = Quantile(absolute[k], 0.5);
  return summary;
}

}  // namespace

Board ExperimentStarBoard(int segments) {
  StarBoardOptions options;
  options.columns = kBoardColumns;
  options.rows = kBoardRows;
  options.square_mm = kBoardSquareM * 1000;
  options.segments = segments;
  Board board = StarBoards(options)[0];
  board.points = board.NominalPoints();
  return board;
}

Board ExperimentChessboard() {
  return ChessboardPattern(kBoardColumns, kBoardRows, kBoardSquareM).boards[0];
}

std::vector<LocalizationError> MeasureLocalization(
    const std::vector<DetectedBoard>& boards,
    const ExperimentOptions& options) {
  std::vector<BoardTrial> trials;
  for (const DetectedBoard& board : boards) trials.emplace_back(board);
  const Outcomes outcomes = RunAll(trials, options);
  const auto compared = FoundInAll(outcomes, options.num_images);
  std::vector<LocalizationError> errors;
  for (size_t trial = 0; trial < trials.size(); ++trial)
    for (size_t way = 0; way < trials[trial].num_ways(); ++way)
      errors.push_back(SummarizeCandidate(outcomes[trial], way, compared));
  return errors;
}

std::vector<Condition> ListLocalizationConditions(
    const ExperimentOptions& options) {
  const ImagingOptions imaging = Imaging(options, 0);
  return {
      {"images",
       fmt::format(
           "{} of {} x {} px, rendered with the same poses for all variants",
           options.num_images, options.size.width, options.size.height)},
      {"lens", fmt::format("{}, 65 degrees", kBoardCamera)},
      {"board", fmt::format("{} x {} features, fully visible", kBoardColumns,
                            kBoardRows)},
      {"squares", fmt::format("{:g} to {:g} px, tilted by 0 to {:g} degrees",
                              kMinSquarePx, kMaxSquarePx, kMaxTiltDeg)},
      {"blur",
       fmt::format("{:g} px (1 sigma), plus the pixel area", imaging.blur_px)},
      {"noise",
       fmt::format("{:g} grey levels (1 sigma); black {:g}, white {:g} of 255",
                   imaging.read_noise, imaging.black_level,
                   imaging.white_level)},
      {"window", fmt::format("{0} x {0} px", DetectionOptions().window_px)},
      {"compared", "features found in all variants"},
      {"seed", std::to_string(options.seed)}};
}

std::string LocalizationNote(const ExperimentOptions& options) {
  const ImagingOptions imaging = Imaging(options, 0);
  return fmt::format(
      "{} images of {} x {} px, squares of {:g} to {:g} px, window {} px, blur "
      "{:g} px, noise {:g} of {:g} grey levels",
      options.num_images, options.size.width, options.size.height, kMinSquarePx,
      kMaxSquarePx, DetectionOptions().window_px, imaging.blur_px,
      imaging.read_noise, imaging.white_level - imaging.black_level);
}

std::vector<std::string> LocalizationColumns(std::vector<std::string> first) {
  for (const char* name : {"visible", "found", "compared", "median_x_px",
                           "median_y_px", "rms_x_px", "rms_y_px", "largest_px"})
    first.push_back(name);
  return first;
}

std::vector<Cell> LocalizationCells(std::vector<Cell> first,
                                    const LocalizationError& error) {
  for (const int count :
       {error.num_visible, error.num_found, error.num_compared})
    first.push_back(count);
  for (const double px :
       {error.median_px.x(), error.median_px.y(), error.rms_px.x(),
        error.rms_px.y(), error.max_error_px})
    first.push_back(px);
  return first;
}

}  // namespace raygrid
