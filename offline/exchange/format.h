/// Formats of other programs, one file each, listed in formats.cc.
#ifndef RAYGRID_EXCHANGE_FORMAT_H
#define RAYGRID_EXCHANGE_FORMAT_H

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "camera/pose.h"
#include "dataset/camera_file.h"
#include "dataset/dataset.h"
#include "exchange/external_model.h"
#include "exchange/external_model_selection.h"

namespace raygrid {

// ---- Data exchanged between formats and commands ---------------------------

/// Projection of a rectified camera in OpenCV and ROS: R rotates camera axes to
/// view axes, P projects points given in axes of the first view.
struct RectifiedProjection {
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 3, 4> p = Eigen::Matrix<double, 3, 4>::Zero();

  /// Returns whether the view has a baseline to the first view.
  bool HasBaseline() const { return p(0, 3) != 0 || p(1, 3) != 0; }
};

/// A camera read from a file.
struct InputCamera {
  std::string name, serial;  ///< "" if not in the file
  ConvertedCamera lens;      ///< size 0 x 0 if not in the file
  std::optional<Pose> camera_from_rig;
  std::optional<RectifiedProjection> rectified;
  std::vector<ImageFeatures> features;  ///< features used for calibration
  std::string
      missing_features_reason;   ///< why features in the file are not imported
  std::vector<BoardPose> poses;  ///< camera_from_board by board and image
  /// Valid region, if the file has one.
  std::optional<ValidityMask> valid_region = {};
};

/// The contents of an imported file.
struct ExchangeContents {
  std::vector<InputCamera> cameras;
  /// Corners of a file without a camera.
  std::vector<ImageFeatures> corners;
  /// The relative pose of two cameras whose intrinsics are in another file.
  std::optional<Pose> second_from_first;
  std::vector<Board> boards;          ///< boards of a file without cameras
  std::vector<std::string> warnings;  ///< about data not imported as they are

  /// Returns whether there are several cameras, all with poses.
  bool IsRig() const;
};

/// A file to read, with the user's options.
struct ReadRequest {
  std::string path, text;
  /// Values of --model and --image-size, for files without them; "" and nullopt
  /// if not specified. ReadExchangeFile() compares them with the file's values.
  std::string external_model;
  std::optional<ImageSize> size;
  /// Texts of the files listed by Format::beside(); "" for missing files.
  std::vector<std::string> beside = {};
  /// --board-size: columns and rows of corners, for files without it.
  std::optional<ImageSize> board = {};
};

/// A camera to write.
struct OutputCamera {
  std::string name, serial;
  ConvertedCamera lens;
  std::optional<ModelFit> fit;          ///< nullopt: exact conversion
  std::optional<Pose> camera_from_rig;  ///< pose of the model's frame, in a rig
  std::optional<RectifiedProjection> rectified;
  std::vector<BoardPose> poses;  ///< board poses in the model's frame
  /// Valid region, if known.
  std::optional<ValidityMask> valid_region = {};
};

struct WriteRequest {
  std::string path;  ///< output file; its extension may select the kind
  std::vector<OutputCamera> cameras;
  /// For formats with file_in_folder(): previous texts of the files listed by
  /// beside(); "" for missing files.
  std::vector<std::string> beside = {};
};

/// A file that is written to the folder of the main file.
struct CompanionFile {
  std::string path, text;
  /// If true, a different file of this name is an error, not overwritten.
  bool is_never_replaced = false;
};

// ---- The table -------------------------------------------------------------

struct Format {
  std::string name;   ///< "opencv", for --to and --from
  std::string holds;  ///< one line for --list
  std::vector<ExternalModel> external_models;  ///< empty: files have no camera
  std::string ending = ".yaml";                ///< extension of files of a rig
  bool supports_rigs = false;        ///< otherwise one camera per file
  bool discards_rig_poses = false;   ///< files of a rig lack poses
  bool supports_pairs = false;       ///< files of two cameras have R and P
  bool supports_poses = false;       ///< files have board poses
  bool supports_region = false;      ///< files have one valid region
  bool accepts_model = false;        ///< files may lack the model: --model
  bool requires_board_size = false;  ///< corners only, without board size
  bool accepts_board_size = false;   ///< corners may lack the board size
  bool requires_image_size = false;  ///< files lack the image size

  /// Returns whether a text has this format, judged by keywords that other
  /// formats do not have. The text may be malformed.
  std::function<bool(const std::string& text)> recognizes;
  /// Throws InputError without the file's name, and yaml-cpp exceptions.
  std::function<ExchangeContents(const ReadRequest& request)> read;
  /// Formats the text of a file; null if the format is read-only.
  std::function<std::string(const WriteRequest& request)> write;
  /// Return the paths of companion files that are read with the main file, and
  /// the companion files to write; null if the format has none.
  std::vector<std::string> (*beside)(const std::string& path) = nullptr;
  std::vector<CompanionFile> (*write_beside)(const WriteRequest& request) =
      nullptr;
  /// For formats in which a rig is a folder of numbered camera files: return
  /// the path of a camera's file, and all files to write (camera files first,
  /// in the order of the cameras' names). The path of the request is the path
  /// of the folder. Null for formats whose files are named after the cameras.
  std::string (*file_in_folder)(const std::string& folder,
                                int camera) = nullptr;
  std::vector<CompanionFile> (*write_folder)(const WriteRequest& request) =
      nullptr;

  /// Returns null if there is no model with this name.
  const ExternalModel* FindExternalModel(
      const std::string& external_model) const;
  /// Returns the models that --model selects: the format's model of this name,
  /// or all based on raygrid's model of this name; "" selects all. Models with
  /// is_explicit_only are selected only by their own name. Throws
  /// Error(kUsage), listing the names.
  std::vector<const ExternalModel*> FindModels(const std::string& model) const;
};

/// Returns all formats, in the order of recognition.
const std::vector<Format>& GetFormats();

/// Finds a format. Throws Error(kUsage), naming the option, if there is none.
const Format& FindFormat(const std::string& option, const std::string& name);

/// Returns the format of a file's text; null if it is raygrid's or unknown.
const Format* RecognizeFormat(const std::string& text);

/// RecognizeFormat() for a camera file. Throws InputError, listing the formats,
/// if the text is neither in one of them nor in raygrid's format.
const Format* RecognizeCamera(const std::string& path, const std::string& text);

/// Formats the list "opencv, ros and kalibr", for errors.
std::string ListFormatNames();

/// Reads a file of the given format, or of the recognized one if null. All its
/// cameras are checked to be valid models. Throws InputError with the file's
/// name.
ExchangeContents ReadExchangeFile(const Format* format,
                                  const ReadRequest& request);

/// Throws InputError if the format contains corners or boards only.
void RequireCameraFormat(const Format& format, const std::string& path);

/// Throws InputError if a file contains corners, but no camera.
void RequireCameras(const ExchangeContents& contents, const std::string& path);

/// Reads the companion files of a file; "" for missing files.
std::vector<std::string> ReadCompanionFiles(const Format& format,
                                            const std::string& path);

/// Returns paths and texts of all files of a request. Throws
/// Error(kOutputFailed) if a file exists that must not be replaced and has
/// other contents.
std::vector<std::pair<std::string, std::string>> WriteWithCompanions(
    const Format& format, WriteRequest request);

/// Returns paths and texts of a rig's files in a folder, for formats with one
/// camera per file.
std::vector<std::pair<std::string, std::string>> WriteFolder(
    const Format& format, WriteRequest request);

/// Computes poses in the frame of the first camera from R and P; none if a
/// camera lacks them, or if no view has a baseline.
void ComputeStereoPoses(std::vector<InputCamera>* cameras);

/// Throws InputError if --model is neither the name of the file's model nor of
/// raygrid's model that it is based on.
void RequireModelOfFile(const ReadRequest& request,
                        const ExternalModel& external_model);

/// Assigns the relative pose from another file, if any, to two cameras. Throws
/// InputError, naming the files, if there are not exactly two cameras without
/// poses.
void AssignPairPose(const std::optional<Pose>& second_from_first,
                    const std::string& files,
                    std::vector<InputCamera>* cameras);

/// Throws InputError if poses refer to several boards, for programs with a
/// single world frame.
void RequireOneBoard(const std::string& program,
                     const std::vector<OutputCamera>& cameras);

/// Converts an imported camera to a camera file.
CameraFile MakeCameraFile(const InputCamera& read);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_FORMAT_H
