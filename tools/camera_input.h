#ifndef RAYGRID_TOOLS_CAMERA_INPUT_H
#define RAYGRID_TOOLS_CAMERA_INPUT_H

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "dataset/camera_file.h"
#include "dataset/dataset.h"
#include "packing/blob_camera.h"
#include "requested_operating_point.h"

namespace raygrid {

/// A camera from camera.yaml, a blob, or a file of another program with one
/// camera (exchange/format.h): the formats that every command accepts.
struct CameraInput {
  CameraFile file;                 ///< a blob's grid in double precision
  std::optional<BlobCamera> blob;  ///< the blob, if the file is one
  /// Calibrated ranges; empty without an operating-point model.
  std::vector<OperatingRange> ranges;
};

/// Reads a camera. at: operating point, if the camera has an operating-point
/// model; the mid-range is used for missing values, with a note on
/// standard error. Throws Error(kUsage) as FixRequestedPointInRange(), and if
/// the camera has no such model.
CameraInput ReadCamera(const std::string& path,
                       const RequestedOperatingPoint& at = {});
/// Adds the argument of a command that projects or unprojects with a camera.
void AddCameraArgument(CLI::App* command, std::string* path);
/// Parses a camera from the bytes of a file; path is used in errors. Reports on
/// standard error what is not imported from another program's file.
CameraInput ParseCamera(const std::string& path, const std::string& bytes,
                        const RequestedOperatingPoint& at = {});

/// Like ReadCamera(), but keeps the dependence on variables that `at` does not
/// specify.
CameraInput ReadCameraOrModel(const std::string& path,
                              const RequestedOperatingPoint& at);

/// Reads two cameras. at: operating point of those with an operating-point
/// model. Values of variables on which one camera does not depend are used for
/// the other one, with a note on standard error. Throws Error(kUsage) if
/// neither depends on them.
std::array<CameraInput, 2> ReadCameraPair(const std::string& first,
                                          const std::string& second,
                                          const RequestedOperatingPoint& at);

/// Reads the features of a single camera with images of this size. Throws
/// InputError for features of several cameras, or of another pattern.
Dataset ReadCameraFeatures(const std::string& path, const ImageSize& size,
                           const Pattern& pattern);

/// Returns the valid region, if the camera's file or blob has one.
std::optional<ValidityMask> LoadValidityMask(const CameraInput& input);

/// Returns the pixels to show of a camera's images with --outside OUTSIDE:
/// nullopt for all, or the valid region. Throws Error(kUsage) if the camera has
/// no valid region.
std::optional<ValidityMask> SelectVisibleMask(const std::string& outside,
                                              const std::string& path,
                                              const CameraInput& input);

/// Warns on standard error if the camera's calibration failed, which results do
/// not show.
void WarnAboutFailedCalibration(const std::string& path,
                                const CameraFile& file);

/// Throws Error(kOutputFailed) if images would be written to the folder of the
/// images that they are generated from, and would be read as input the next
/// time.
void RequireSeparateFolders(const std::vector<std::string>& images,
                            const std::string& folder);

/// Writes text to a file, or to standard output if path is empty.
void PrintOrWrite(const std::string& path, const std::string& text);

/// Returns the maximum number of points or pixels per call: the pixels of a
/// Full HD image, fewer for JSON. The output is kept in memory, because outputs
/// are written completely or not at all.
inline size_t MaxRows(bool is_json) { return is_json ? 500000 : 2100000; }

/// Converts a CSV table of numbers to an array of objects: empty fields become
/// null, a column "valid" true and false.
std::string ConvertCsvToJson(const std::string& csv,
                             const std::vector<std::string>& columns);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CAMERA_INPUT_H
