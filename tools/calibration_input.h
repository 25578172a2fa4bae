/// Input of raygrid calibrate: a single camera or the cameras of a rig.
#ifndef RAYGRID_TOOLS_CALIBRATION_INPUT_H
#define RAYGRID_TOOLS_CALIBRATION_INPUT_H

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "bag_input.h"
#include "calibration/calibration.h"
#include "camera/sensor_mode.h"
#include "camera_values.h"
#include "checkpoint_file.h"
#include "commands.h"
#include "dataset/camera_file.h"
#include "dataset/capture.h"
#include "dataset/repeated_images.h"
#include "known_intrinsics.h"
#include "progress_bar.h"

namespace raygrid {

struct CalibrateArguments {
  std::vector<std::string> images, cameras, image_sizes, hold_out, modes;
  std::vector<std::string> intrinsics;  ///< NAME=FILE, --intrinsics
  std::string features, pattern, output, name, serial, like;
  std::string model = "auto", knot_spacing_px = "auto";
  std::string duplicate_px = "auto", valid_px = "auto";
  std::string sync_by = "name", area = "image", image_circle = "auto";
  bool fix_target_geometry = false, rigid_board = false,
       independent_boards = false, measure_once = false, resume = false,
       allow_noncentral = false;
  bool skip_comparison = false, rolling_shutter = false;
  std::string times;  ///< CSV file with the times of images
  BagOptions bags;
  /// Images of a session or bags, instead of cameras.
  std::vector<RigCameraImages> rig;
  std::vector<Capture> captures;  ///< capture settings of a session's cameras
  /// Operating-point variables on which the intrinsics depend; may be empty.
  std::vector<std::string> condition;
  std::vector<std::string> cameras_at;
  std::string conditions;  ///< CSV file
  /// Values of these variables by image of a session.
  std::map<std::string, OperatingPoint> session_values;
  /// Times of the images of each camera of a session or bags.
  std::vector<ImageTimes> session_times;

  /// Whether images of several cameras are given.
  bool HasCameraImages() const { return !cameras.empty() || !rig.empty(); }
};

/// Features by camera name; the name is "" for a single camera.
using FeaturesByCamera = std::map<std::string, Dataset>;

/// Images of a dataset that were captured in another sensor mode: from `first`
/// up to the first image of the next mode.
struct ModeImages {
  SensorMode mode;
  size_t first = 0;
};

/// The features of a camera to calibrate, and the images in which they were
/// detected, if any.
struct Measurements {
  std::string camera;  ///< name of the camera in a rig, or ""
  Dataset dataset;
  std::vector<std::string> paths;  ///< paths of the dataset's images
  std::vector<ModeImages> modes;   ///< the last images of the dataset
  /// Operating points by image, from --images-at or EXIF.
  std::map<std::string, OperatingPoint> condition_values;
  std::optional<ImageCircle> image_circle;
  std::vector<RejectedImage> skipped;   ///< images without usable features
  std::vector<RejectedImage> left_out;  ///< files that are not photographs, and
                                        ///< copies
  std::vector<ImagePair> copies;        ///< an image and its copy
};

/// Returns the number of images in the calibrated sensor mode, the first ones.
size_t NumCalibratedImages(const Measurements& measurements);

/// Appends measurements of other images of the same camera.
void Append(Measurements more, Measurements* measurements);

/// Removes and lists images whose features equal another image's to 0.001 px: a
/// copy of a training image would be predicted too well if held out, and be
/// counted twice otherwise. A held-out copy of an image that is not held out is
/// kept; the assessment warns of it.
void ExcludeCopies(Measurements* measurements,
                   const std::vector<std::string>& hold_out = {});

/// Detects the pattern in images and folders. Unusable images are listed on
/// stderr and skipped. Throws Error(kInsufficientData) if they show another
/// board than the pattern, which messages call pattern_name.
Measurements DetectAll(const std::vector<std::string>& images,
                       const Pattern& pattern, const std::string& pattern_name,
                       const CommonOptions& common,
                       const std::function<void(double)>& progress);

/// Calls DetectAll() and ExcludeCopies().
Measurements Measure(const std::vector<std::string>& images,
                     const Pattern& pattern, const std::string& pattern_name,
                     const CommonOptions& common,
                     const std::function<void(double)>& progress,
                     const std::vector<std::string>& hold_out = {});

/// Reads --features; empty if images are given instead. Throws Error(kUsage) if
/// both or neither are given.
FeaturesByCamera ReadFeatureInputs(const CalibrateArguments& arguments);

/// Detects features in the images of each camera, or uses the given features. A
/// single camera has no name. Throws Error: kUsage, kInsufficientData;
/// InputError.
std::vector<Measurements> CollectMeasurements(
    const CalibrateArguments& arguments, const CommonOptions& common,
    const FeaturesByCamera& given, const Pattern& pattern, ProgressBar* bar);

struct CaptureMetadata;

/// Adds --camera, --sync-by and --features, which calibrate and localize share.
void AddRigImageOptions(CLI::App* command, std::vector<std::string>* folders,
                        std::string* sync_by, std::string* features);

/// Returns the inputs of a calibration, with the checkpoints of an interrupted
/// one, if any. They refer to `cameras` and `checkpoints`, which must outlive
/// them.
std::vector<CalibrationInput> MakeCalibrationInputs(
    const std::vector<Measurements>& cameras,
    const CaptureMetadata& capture_metadata,
    const CalibrateArguments& arguments, const IntrinsicsByCamera& intrinsics,
    int num_threads, CheckpointFile* checkpoints);

/// Reads --intrinsics for the cameras of --camera, --features or a session.
/// Throws Error(kUsage), also for options that known intrinsics exclude.
IntrinsicsByCamera ReadKnownIntrinsics(const CalibrateArguments& arguments,
                                       const FeaturesByCamera& given);

/// Throws Error(kOutputFailed) if the result would overwrite the pattern, the
/// features or an image.
void RequireNoInputReplaced(const CalibrateArguments& arguments,
                            const std::vector<std::string>& images);

/// Serializes features, pattern and relevant options, to detect changed inputs.
std::string SerializeInputs(const CalibrateArguments& arguments,
                            const CommonOptions& common,
                            const std::vector<Measurements>& cameras,
                            const CaptureMetadata& capture_metadata,
                            const IntrinsicsByCamera& intrinsics,
                            const Pattern& pattern);

/// Converts command-line options. Throws Error(kUsage).
CalibrationOptions MakeCalibrationOptions(const CalibrateArguments& arguments,
                                          const CommonOptions& common,
                                          ProgressBar* bar);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CALIBRATION_INPUT_H
