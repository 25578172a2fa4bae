#ifndef RAYGRID_CALIBRATION_CALIBRATION_H
#define RAYGRID_CALIBRATION_CALIBRATION_H

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "camera/model_names.h"
#include "camera/population_covariance.h"
#include "dataset/camera_file.h"
#include "dataset/dataset.h"
#include "dataset/image_times.h"
#include "evaluation/rig_result.h"

namespace raygrid {

/// Called with the updated checkpoint whenever a further step is complete.
using CheckpointCallback = std::function<void(const Checkpoint&)>;

/// Called with the current stage and the progress of the entire calibration, 0
/// to 1.
using ProgressCallback =
    std::function<void(const std::string& stage, double done)>;

/// Refines the features of a dataset, given a first camera model, the pattern
/// with its estimated geometry, and the board poses. The result is ignored once
/// should_stop() returns true.
using RefineFeaturesCallback = std::function<Dataset(
    const CameraModel&, const Pattern&, const std::vector<BoardPose>&)>;

/// A camera to calibrate, and its features.
struct CalibrationInput {
  std::string name;  ///< unique within a rig
  Dataset dataset;
  RefineFeaturesCallback refine_features =
      nullptr;  ///< null: features are kept
  /// Checkpoint of an interrupted calibration with the same features and
  /// options, or nullopt. The result is bit-identical to that of an
  /// uninterrupted calibration.
  std::optional<Checkpoint> resume = {};
  CheckpointCallback keep = nullptr;
  /// Image circle, if it is known and smaller than the image.
  std::optional<ImageCircle> image_circle = {};
  /// Images that were skipped before detection; listed in the result.
  std::vector<RejectedImage> skipped = {};
  /// Times of the images, for the line delay; nullopt: not estimated.
  std::optional<ImageTimes> times = {};
  /// Known intrinsics, which are kept; null: estimated.
  std::shared_ptr<const CameraFile> intrinsics = {};
};

/// Returns the names of the supported models, in descending order of their
/// parameters.
std::vector<std::string> ListCalibratedModels();

struct CalibrationOptions {
  /// One of ListCalibratedModels(), or "auto": the model that predicts held-out
  /// images best (model_selection.h), or central-generic if knot_spacing_px or
  /// like is given.
  std::string model = models::kCentralGeneric;
  bool allow_noncentral = false;      ///< for "auto"
  double knot_spacing_px = 0;         ///< 0: chosen by held-out error
  bool allow_large_distance = false;  ///< allows boards more than 20 m away
  AreaChoice area = AreaChoice::kWholeImage;
  /// Prior camera: a calibrated camera of a similar lens. The grid's prior is
  /// centred on it instead of a parametric model, so fewer images suffice. For
  /// central-generic and a single camera with images of the same size.
  std::shared_ptr<const CameraModel> like = {};
  /// Variation over the fleet, if `like` is its population mean.
  std::shared_ptr<const PopulationCovariance> prior_population = {};
  /// Fixes the target geometry: nominal points without deformation.
  bool fix_target_geometry = false;
  bool rigid_board = false;  ///< board deformation is static
  /// Boards are not joined even if their relative poses seem constant.
  bool independent_boards = false;
  /// Names of held-out images; for a rig, of held-out frames.
  std::vector<std::string> hold_out;
  /// Feature motion below which images are near-duplicates; nullopt:
  /// DefaultDuplicatePx(); 0: no near-duplicates.
  std::optional<double> duplicate_px = {};
  /// Limit of the predicted uncertainty in the valid region; nullopt:
  /// DefaultValidLimitPx().
  std::optional<double> valid_px = {};
  bool compare_models = false;  ///< also fits parametric models (slow)
  int num_threads = 0;
  ProgressCallback progress;
  /// If it returns true, calibration stops with the best state so far.
  std::function<bool()> should_stop;

  bool ShouldStop() const { return should_stop && should_stop(); }
};

/// Calibrates a single camera, or the cameras of a rig and their poses, from
/// features. Images of the same name belong to one frame. The rig's frame of
/// reference is the first camera's. With known intrinsics of all cameras, only
/// poses and the target geometry are estimated. Throws Error: kInsufficientData
/// or kInitializationFailed; kUsage if boards are implausibly far away, or if
/// known intrinsics are for images of another size.
RigResult Calibrate(const std::vector<CalibrationInput>& cameras,
                    const Pattern& pattern, const CalibrationOptions& options);

/// Calibrates a single camera without feature refinement.
CalibrationResult Calibrate(const Dataset& dataset, const Pattern& pattern,
                            const CalibrationOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CALIBRATION_H
