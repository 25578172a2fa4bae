#ifndef RAYGRID_CALIBRATION_CALIBRATION_H
#define RAYGRID_CALIBRATION_CALIBRATION_H

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "camera/lens_spread.h"
#include "camera/model_names.h"
#include "dataset/dataset.h"
#include "dataset/image_times.h"
#include "evaluation/rig_result.h"

namespace raygrid {

/// A callback that is told what need not be done again, whenever there is more
/// of it.
using CheckpointCallback = std::function<void(const Checkpoint&)>;

/// A callback that is told the stage, and how much of the whole is done: 0 to
/// 1.
using ProgressCallback =
    std::function<void(const std::string& stage, double done)>;

/// A function that measures the features of a dataset once more. It is given a
/// first camera's model, the pattern as it was found to be, and where boards
/// stood. Once should_stop says so, it may return anything.
using RefineFeaturesCallback = std::function<Dataset(
    const CameraModel&, const Pattern&, const std::vector<BoardPose>&)>;

/// A camera to calibrate, and what it saw.
struct CalibrationInput {
  std::string name;  ///< cameras of a rig have different ones
  Dataset dataset;
  RefineFeaturesCallback refine_features =
      nullptr;  ///< without: features stay as they are
  /// The checkpoint of an interrupted calibration with the same features and
  /// options, or none. The result has the same bits as that of a calibration
  /// without interruption.
  std::optional<Checkpoint> resume = {};
  CheckpointCallback keep = nullptr;
  /// The part of its images that the lens lights, if that is known to be less
  /// than all.
  std::optional<ImageCircle> image_circle = {};
  /// Images that were given, but not measured; the result names them.
  std::vector<RejectedImage> skipped = {};
  /// When images were taken, to estimate the time of a row by; nothing: do not.
  std::optional<ImageTimes> times = {};
};

/// The models that calibrate, from the one with the most parameters.
std::vector<std::string> CalibratedModels();

struct CalibrationOptions {
  /// Or another of CalibratedModels(), or "auto": the one that predicts
  /// held-out images best (model_selection.h); central-generic, if
  /// knot_spacing_px or like is given.
  std::string model = models::kCentralGeneric;
  bool allow_noncentral = false;      ///< for "auto"
  double knot_spacing_px = 0;         ///< 0: chosen by held-out error
  bool allow_large_distance = false;  ///< boards may be more than 20 m away
  AreaChoice area = AreaChoice::kWholeImage;
  /// A calibrated camera of a like lens: a grid lies around it, instead of
  /// around a lens of few parameters, so few images do. For central-generic, a
  /// single camera and images of its size.
  std::shared_ptr<const CameraModel> like = {};
  /// How lenses differ from it, if it is a fleet's middle camera.
  std::shared_ptr<const LensSpread> prior_spread = {};
  /// The pattern's points are kept as they are given, in each image.
  bool fix_target_geometry = false;
  bool rigid_board = false;  ///< boards are bent alike in all images
  /// Several boards move by themselves, even if they seem fixed to each other.
  bool independent_boards = false;
  /// Images not to calibrate with; of a rig, instants.
  std::vector<std::string> hold_out;
  /// How far features move between images that count as one view; nothing:
  /// DefaultDuplicatePx(); 0: each image is a view.
  std::optional<double> duplicate_px = {};
  /// The valid region is where the predicted uncertainty is below this;
  /// nothing: DefaultValidLimitPx().
  std::optional<double> valid_px = {};
  bool compare_models = false;  ///< also fit parametric ones, which takes time
  int num_threads = 0;
  ProgressCallback progress;
  /// Once true, the best state so far is the result.
  std::function<bool()> should_stop;

  bool ShouldStop() const { return should_stop && should_stop(); }
};

/// Calibrates a single camera, or the cameras of a rig and their poses, from
/// features. Images of one name show one instant. The first camera's frame is
/// the rig's. Throws Error: kTooFew or kInitialization; for boards further away
/// than likely, kUsage.
RigResult Calibrate(const std::vector<CalibrationInput>& cameras,
                    const Pattern& pattern, const CalibrationOptions& options);

/// Calibrates a single camera whose features stay as they are.
CalibrationResult Calibrate(const Dataset& dataset, const Pattern& pattern,
                            const CalibrationOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CALIBRATION_H
