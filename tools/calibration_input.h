/// The parts of calibrate that are alike for one camera and for a rig.
#ifndef RAYGRID_TOOLS_CALIBRATION_INPUT_H
#define RAYGRID_TOOLS_CALIBRATION_INPUT_H

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "calibration/calibration.h"
#include "commands.h"
#include "dataset/camera_file.h"
#include "packing/pack.h"
#include "progress_bar.h"
#include "report/result_json.h"

namespace raygrid {

struct CalibrateArguments {
  std::vector<std::string> images, cameras, image_sizes, hold_out;
  std::string features, pattern, output, name, serial;
  std::string model = "central-generic", cell_px = "auto";
  std::string instant_by = "name";
  bool flat_board = false, measure_once = false, resume = false;
  bool skip_comparison = false;
};

using FeaturesByCamera = std::map<std::string, Dataset>;

/// The features to calibrate with, and the images that they were measured in,
/// if any.
struct Measurements {
  Dataset dataset;
  std::vector<std::string> paths;       ///< of the dataset's images
  std::vector<RejectedImage> skipped;   ///< could not be measured
  std::vector<RejectedImage> left_out;  ///< no photographs, copies
};

/// Detects the pattern in images and folders; those that cannot be used are
/// named on stderr, and the
/// others are gone on with. Throws Error(kTooFew) if they show another board
/// than the pattern, whose name is for messages.
Measurements Measure(const std::vector<std::string>& images,
                     const Pattern& pattern, const std::string& pattern_name,
                     const CommonOptions& common,
                     const std::function<void(double)>& progress);

/// Images that show the same as others to 0.001 px leave, and are named: a copy
/// would be predicted by a camera that was calibrated with it.
void LeaveOutCopies(Measurements* measurements);

/// Throws Error(kTooFew) without features, and as RequireConsistent.
void RequireUsable(const std::string& source,
                   const CalibrateArguments& arguments,
                   const Measurements& measurements, const Pattern& pattern);

/// Throws Error(kOutput) if the result would replace the pattern, the features
/// or an image.
void RequireNoInputReplaced(const CalibrateArguments& arguments,
                            const std::vector<std::string>& images);

/// The way to measure images again; empty for features alone, or if they are to
/// be kept.
MeasureAgain AgainIn(const Measurements& measurements,
                     const CalibrateArguments& arguments, int num_threads);

/// Names what is no photograph, which a verdict does not count.
void AddLeftOut(const Measurements& measurements, CalibrationResult* result);

/// Tells features, pattern and what matters of the options from others.
std::string InputsOf(const CalibrateArguments& arguments,
                     const CommonOptions& common,
                     const std::vector<Measurements>& cameras,
                     const Pattern& pattern);

/// resume.json while a calibration is at work: a program that is killed leaves
/// it. The result that is written to the folder takes it away, and so does a
/// calibration that fails.
class CheckpointFile {
 public:
  /// inputs are InputsOf() those cameras.
  CheckpointFile(const std::string& folder, const std::string& inputs,
                 size_t num_cameras);
  ~CheckpointFile();
  CheckpointFile(const CheckpointFile&) = delete;
  CheckpointFile& operator=(const CheckpointFile&) = delete;

  /// Takes up what was written before; throws as ReadCheckpoints().
  void Read();
  const Checkpoint& Of(size_t camera) const { return checkpoints_[camera]; }

  /// Writes them all, now or with one of the next.
  void Keep(size_t camera, const Checkpoint& checkpoint);

 private:
  std::string path_, inputs_;
  std::vector<Checkpoint> checkpoints_;
  std::chrono::steady_clock::time_point next_write_ = {};
  bool is_written_ = false;
};

/// Throws Error(kUsage).
CalibrationOptions OptionsOf(const CalibrateArguments& arguments,
                             const CommonOptions& common, ProgressBar* bar);

PackingFigures FiguresOf(const PackedCamera& packed);

/// Prints what a blob lacks, on standard error; name is for it.
void PrintRemarks(const std::string& name, const PackedCamera& packed);

int64_t PeakMemoryBytes();

void PrintFigures(const char* name, const ErrorFigures& figures);

/// The training errors, and how many features have none.
void PrintTraining(const CalibrationResult& result);

void PrintUncertainty(const CameraUncertainty& uncertainty,
                      const CameraModel& camera);

/// Throws what the exit code says of a calibration whose files are written:
/// Error(kNotConverged) if it was interrupted, Error(kQuality) if its verdict
/// is "fail".
void RequireSuccess(const Verdict& verdict, bool is_interrupted,
                    const std::string& folder);

/// Keeps a finished result from being replaced by what was found so far: where
/// the folder holds one, this writes resume.json alone and throws
/// Error(kNotConverged). Without checkpoints, nothing was interrupted.
void KeepFinishedResult(const std::string& folder,
                        const std::vector<Checkpoint>& checkpoints,
                        const std::string& inputs);

/// Calibrates a rig: in folders of images, or with the features given.
void RunRig(const CalibrateArguments& arguments, const CommonOptions& common,
            const FeaturesByCamera& given);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CALIBRATION_INPUT_H
