#ifndef RAYGRID_CALIBRATION_CALIBRATION_H
#define RAYGRID_CALIBRATION_CALIBRATION_H

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "evaluation/rig_result.h"

namespace raygrid {

/// Told what need not be done again, whenever there is more of it.
using KeepCheckpoint = std::function<void(const Checkpoint&)>;

/// Told the stage and how much of the whole is done, 0 to 1.
using Progress = std::function<void(const std::string& stage, double done)>;

/// Measures the features of a dataset once more, through a first camera: its
/// model, the pattern as it was found to be, where the boards stood. May return
/// anything once should_stop says so.
using MeasureAgain = std::function<Dataset(const CameraModel&, const Pattern&,
                                           const std::vector<BoardPose>&)>;

/// A camera to calibrate, and what it saw.
struct CalibrationInput {
  std::string name;  ///< cameras of a rig have different ones
  Dataset dataset;
  MeasureAgain measure_again = nullptr;  ///< without: features stay as they are
  /// The checkpoint of an interrupted calibration with the same features and
  /// options, or none. The result is to the bit that of a calibration without
  /// interruption.
  std::optional<Checkpoint> resume = {};
  KeepCheckpoint keep = nullptr;
  /// Images that were given, but not measured; the result names them.
  std::vector<RejectedImage> skipped = {};
};

struct CalibrationOptions {
  std::string model = "central-generic";  ///< or a parametric one
  double cell_px = 0;                     ///< 0: chosen by held-out error
  bool any_distance = false;              ///< boards may be more than 20 m away
  bool flat_board = false;  ///< keep the pattern's points as they are given
  /// Images not to calibrate with; of a rig, instants.
  std::vector<std::string> hold_out;
  bool compare_models = false;  ///< with parametric ones, which takes time
  int num_threads = 0;
  Progress progress;
  /// Once true, the best state so far is the result.
  std::function<bool()> should_stop;

  bool ShouldStop() const { return should_stop && should_stop(); }
};

/// Calibrates a single camera, or the cameras of a rig and their poses, from
/// features. Images of one name show one instant. The first camera's frame is
/// the rig's. Throws Error: kTooFew, kInitialization, kUsage for boards further
/// away than likely.
RigResult Calibrate(const std::vector<CalibrationInput>& cameras,
                    const Pattern& pattern, const CalibrationOptions& options);

/// Calibrates a single camera whose features stay as they are.
CalibrationResult Calibrate(const Dataset& dataset, const Pattern& pattern,
                            const CalibrationOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CALIBRATION_H
