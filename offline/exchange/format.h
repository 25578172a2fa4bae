/// Formats of other programs, one file each: a row of the table in formats.cc.
#ifndef RAYGRID_EXCHANGE_FORMAT_H
#define RAYGRID_EXCHANGE_FORMAT_H

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "camera/pose.h"
#include "dataset/camera_file.h"
#include "dataset/dataset.h"
#include "exchange/lens_form.h"
#include "exchange/lens_selection.h"

namespace raygrid {

// ---- What passes between a format and the commands -------------------------

/// A camera of a rectified pair as OpenCV and ROS have it: R turns axes of the
/// lens into those of the view, P projects points in axes of the first view.
struct RectifiedProjection {
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 3, 4> p = Eigen::Matrix<double, 3, 4>::Zero();

  /// Whether the view stands beside another one.
  bool IsBeside() const { return p(0, 3) != 0 || p(1, 3) != 0; }
};

/// A camera that was read.
struct ReadLens {
  std::string name, serial;  ///< "" where the file does not tell
  ConvertedLens lens;        ///< its size is 0 x 0 likewise
  std::optional<Pose> camera_from_rig;
  std::optional<RectifiedProjection> rectified;
  std::vector<ImageFeatures> features;  ///< that it was calibrated with
  std::string
      missing_features_reason;   ///< if the file has some that are not taken
  std::vector<BoardPose> poses;  ///< of boards, camera_from_board
  /// The cells that it can be trusted in.
  std::optional<ValidityMask> trusted = {};
};

/// The contents of a file that was read.
struct ExchangeContents {
  std::vector<ReadLens> cameras;
  /// Corners of a file that has no camera.
  std::vector<ImageFeatures> corners;
  /// The pose of a pair whose cameras stand in another file.
  std::optional<Pose> second_from_first;
  std::vector<Board> boards;          ///< of a file that has boards alone
  std::vector<std::string> warnings;  ///< what was not taken as it stands

  /// Whether there are several cameras, and all have poses.
  bool IsRig() const;
};

/// The file, and what the user says of it.
struct ReadRequest {
  std::string path, text;
  /// --model and --image-size, for files that do not say these; "" and nothing
  /// if not given. ReadExchangeFile() compares them with what a file says.
  std::string form;
  std::optional<ImageSize> size;
  /// Texts of the files that Format::beside() names; "" of one that is not
  /// there.
  std::vector<std::string> beside = {};
  /// --board-size: the corners of a row and of a column; the file does not
  /// tell.
  std::optional<ImageSize> board = {};
};

/// A camera to be written.
struct WrittenLens {
  std::string name, serial;
  ConvertedLens lens;
  std::optional<LensFit> fit;  ///< none if the lens is the camera itself
  std::optional<Pose> camera_from_rig;  ///< of the lens's frame, in a rig
  std::optional<RectifiedProjection> rectified;
  std::vector<BoardPose> poses;  ///< of boards, in the lens's frame
  /// The cells that it can be trusted in.
  std::optional<ValidityMask> trusted = {};
};

struct WriteRequest {
  std::string path;  ///< of the file; its ending may tell the kind
  std::vector<WrittenLens> cameras;
  /// For formats with file_in_folder(): texts of the files that beside() names,
  /// as they are before; "" of one that is not there.
  std::vector<std::string> beside = {};
};

/// A file that is written beside the first one.
struct CompanionFile {
  std::string path, text;
  /// Another file of this name is not replaced: it would be a loss.
  bool is_never_replaced = false;
};

// ---- The table -------------------------------------------------------------

struct Format {
  std::string name;                  ///< "opencv", for --to and --from
  std::string holds;                 ///< one line for --list
  std::vector<LensForm> forms;       ///< none if files have no camera
  std::string ending = ".yaml";      ///< of the files of a rig's cameras
  bool supports_rigs = false;        ///< else a file has one camera
  bool discards_rig_poses = false;   ///< files of a rig's cameras have no poses
  bool supports_pairs = false;       ///< files of two cameras have R and P
  bool supports_poses = false;       ///< of boards
  bool supports_region = false;      ///< one, around what can be trusted
  bool accepts_model = false;        ///< --model: files may not say it
  bool requires_board_size = false;  ///< corners alone, without a board's width
  bool accepts_board_size = false;   ///< corners that may lack a board's width
  bool requires_image_size = false;  ///< files do not say the size of images

  /// Whether a text is of this format, by words that others have not. It need
  /// not be well-formed.
  std::function<bool(const std::string& text)> recognizes;
  /// Throws InputError without the file's name, and what yaml-cpp throws.
  std::function<ExchangeContents(const ReadRequest& request)> read;
  /// The text of a file; null if the format is only read.
  std::function<std::string(const WriteRequest& request)> write;
  /// Paths of files that may stand beside the first, and those that are written
  /// with it; null if there are none.
  std::vector<std::string> (*beside)(const std::string& path) = nullptr;
  std::vector<CompanionFile> (*write_beside)(const WriteRequest& request) =
      nullptr;
  /// For formats whose cameras of a rig are files of one folder, by their
  /// numbers: the path of a camera, and all files, first those of the cameras
  /// in the order of their names. The request's path is the folder's. Null if
  /// files have the cameras' names.
  std::string (*file_in_folder)(const std::string& folder,
                                int camera) = nullptr;
  std::vector<CompanionFile> (*write_folder)(const WriteRequest& request) =
      nullptr;

  /// Null if there is none of this name.
  const LensForm* FindForm(const std::string& form) const;
  /// The forms that --model leaves to choose from: the one of this name, or
  /// those of raygrid's model of this name. "" leaves all. Those that are only
  /// made when asked for are left by their own name alone. Throws
  /// Error(kUsage), with the names that there are.
  std::vector<const LensForm*> FindForms(const std::string& model) const;
};

/// All formats, in the order in which files are recognized.
const std::vector<Format>& Formats();

/// Throws Error(kUsage), naming the option, if there is none of this name.
const Format& FindFormat(const std::string& option, const std::string& name);

/// The format that a file's text is of; null if it is of none of these, or
/// raygrid's own.
const Format* RecognizeFormat(const std::string& text);

/// RecognizeFormat() of a file that is to be a camera. Throws InputError,
/// naming the formats, if it is of none of them and not raygrid's own.
const Format* RecognizeCamera(const std::string& path, const std::string& text);

/// "opencv, ros and kalibr", for errors.
std::string FormatNames();

/// The contents of a file of a format, or of the one that its text is of if
/// null is given: all its lenses can be made. Throws InputError, naming the
/// file.
ExchangeContents ReadExchangeFile(const Format* format,
                                  const ReadRequest& request);

/// Throws InputError if files of a format have corners or boards, and no
/// camera.
void RequireCameraFormat(const Format& format, const std::string& path);

/// Throws InputError if a file that was read has corners, and no camera.
void RequireCameras(const ExchangeContents& contents, const std::string& path);

/// The texts of the files beside one that is to be read; "" of one that is not
/// there.
std::vector<std::string> ReadCompanionFiles(const Format& format,
                                            const std::string& path);

/// Paths and texts of all files that a format writes for a request. Throws
/// Error(kOutput) if one is there, of something else, that is never replaced.
std::vector<std::pair<std::string, std::string>> WriteWithCompanions(
    const Format& format, WriteRequest request);

/// Paths and texts of a rig's files in a folder, of a format that has one
/// camera a file.
std::vector<std::pair<std::string, std::string>> WriteFolder(
    const Format& format, WriteRequest request);

/// The poses of cameras that have R and P, in the frame of the first one; none
/// if a camera has not even these, or no view stands beside another one.
void ComputePairPoses(std::vector<ReadLens>* cameras);

/// Throws InputError if --model is neither the name of the form that a file
/// says, nor that of its model.
void RequireModelOfFile(const ReadRequest& request, const LensForm& form);

/// The pose of a pair whose cameras stand in another file, if there is one.
/// Throws InputError, naming the files, if they are not two cameras without
/// poses.
void AssignPairPose(const std::optional<Pose>& second_from_first,
                    const std::string& files, std::vector<ReadLens>* cameras);

/// Throws InputError if poses are not all of one board, as programs ask that
/// have one world.
void RequireOneBoard(const std::string& program,
                     const std::vector<WrittenLens>& cameras);

/// A camera that was read as a camera file.
CameraFile MakeCameraFile(const ReadLens& read);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_FORMAT_H
