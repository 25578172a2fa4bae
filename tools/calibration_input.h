/// The cameras that calibrate is given, a single one or those of a rig.
#ifndef RAYGRID_TOOLS_CALIBRATION_INPUT_H
#define RAYGRID_TOOLS_CALIBRATION_INPUT_H

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "calibration/calibration.h"
#include "camera/sensor_mode.h"
#include "checkpoint_file.h"
#include "commands.h"
#include "dataset/camera_file.h"
#include "dataset/capture.h"
#include "dataset/repeated_images.h"
#include "progress_bar.h"

namespace raygrid {

/// The images of a rig's camera, or of a single one, without a name.
struct NamedImages {
  std::string camera;
  std::vector<std::string> images;
};

struct CalibrateArguments {
  std::vector<std::string> images, cameras, image_sizes, hold_out, modes;
  std::string features, pattern, output, name, serial, like;
  std::string model = "auto", knot_spacing_px = "auto";
  std::string duplicate_px = "auto", valid_px = "auto";
  std::string instant_by = "name", area = "image", image_circle = "auto";
  bool fix_target_geometry = false, rigid_board = false,
       independent_boards = false, measure_once = false, resume = false,
       allow_noncentral = false;
  bool skip_comparison = false, rolling_shutter = false;
  std::string times;              ///< a CSV with the times of images
  std::vector<NamedImages> rig;   ///< of a session, instead of cameras
  std::vector<Capture> captures;  ///< how a session's cameras stood
  /// To calibrate over, by their names; empty: none.
  std::vector<std::string> condition;
  std::vector<std::string> cameras_at;
  std::string conditions;  ///< CSV file
  /// Of a session's frames, the values of the conditions.
  std::map<std::string, OperatingPoint> session_values;
  /// When the images of each of a session's cameras were taken.
  std::vector<ImageTimes> session_times;

  /// Whether there are images of several cameras.
  bool HasCameraImages() const { return !cameras.empty() || !rig.empty(); }
};

/// The features of the only camera, or those of several by its name.
using FeaturesByCamera = std::map<std::string, Dataset>;

/// Images of a dataset from the first one on, up to those of the next mode,
/// that were taken in another sensor mode.
struct ImagesOfMode {
  SensorMode mode;
  size_t first = 0;
};

/// The features to calibrate a camera with, and the images that they were
/// measured in, if any.
struct Measurements {
  std::string camera;  ///< its name in a rig
  Dataset dataset;
  std::vector<std::string> paths;   ///< of the dataset's images
  std::vector<ImagesOfMode> modes;  ///< the last of the dataset's images
  /// By image, with --images-at or of EXIF: the values of the conditions.
  std::map<std::string, OperatingPoint> condition_values;
  std::optional<ImageCircle> image_circle;
  std::vector<RejectedImage> skipped;   ///< could not be measured
  std::vector<RejectedImage> left_out;  ///< no photographs, copies
  std::vector<ImagePair> copies;        ///< of an image, and its copy
};

/// How many of the images, the first ones, are as calibrated.
size_t NumCalibratedImages(const Measurements& measurements);

/// Adds more images of the same camera.
void Append(Measurements more, Measurements* measurements);

/// Images that show the same as others to 0.001 px leave, and are named: a copy
/// would be predicted by a camera that was calibrated with it, and counted
/// twice. Images held out stay beside those that are not, of which the verdict
/// warns.
void ExcludeCopies(Measurements* measurements,
                   const std::vector<std::string>& hold_out = {});

/// Detects the pattern in images and folders; those that cannot be used are
/// named on stderr, and the
/// others are gone on with. Throws Error(kTooFew) if they show another board
/// than the pattern, whose name is for messages.
Measurements Measure(const std::vector<std::string>& images,
                     const Pattern& pattern, const std::string& pattern_name,
                     const CommonOptions& common,
                     const std::function<void(double)>& progress,
                     const std::vector<std::string>& hold_out = {});

/// Reads --features; nothing if there are images instead. Throws Error(kUsage)
/// if there are both or none.
FeaturesByCamera ReadGivenFeatures(const CalibrateArguments& arguments);

/// Measures the images of each camera, or takes the features given. A single
/// camera has no name. Throws Error: kUsage, kTooFew; InputError.
std::vector<Measurements> CollectMeasurements(
    const CalibrateArguments& arguments, const CommonOptions& common,
    const FeaturesByCamera& given, const Pattern& pattern, ProgressBar* bar);

struct CaptureConditions;

/// The inputs of a calibration, with the checkpoints of an interrupted one, if
/// there are any. They use cameras and checkpoints.
std::vector<CalibrationInput> CalibrationInputs(
    const std::vector<Measurements>& cameras,
    const CaptureConditions& circumstances, const CalibrateArguments& arguments,
    int num_threads, CheckpointFile* checkpoints);

/// Throws Error(kOutput) if the result would replace the pattern, the features
/// or an image.
void RequireNoInputReplaced(const CalibrateArguments& arguments,
                            const std::vector<std::string>& images);

/// Tells features, pattern and what matters of the options from others.
std::string SerializeInputs(const CalibrateArguments& arguments,
                            const CommonOptions& common,
                            const std::vector<Measurements>& cameras,
                            const CaptureConditions& circumstances,
                            const Pattern& pattern);

/// Throws Error(kUsage).
CalibrationOptions MakeCalibrationOptions(const CalibrateArguments& arguments,
                                          const CommonOptions& common,
                                          ProgressBar* bar);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CALIBRATION_INPUT_H
