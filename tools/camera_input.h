#ifndef RAYGRID_TOOLS_CAMERA_INPUT_H
#define RAYGRID_TOOLS_CAMERA_INPUT_H

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "dataset/camera_file.h"
#include "packing/blob_camera.h"
#include "requested_operating_point.h"

namespace raygrid {

/// A camera.yaml, a blob, or a file of another program that has one camera
/// (exchange/format.h), which every command takes.
struct CameraInput {
  CameraFile file;                 ///< a blob's grid in double precision
  std::optional<BlobCamera> blob;  ///< if it was one
  /// That it was calibrated over, if it is of a stack.
  std::vector<OperatingRange> ranges;
};

/// at: the values of the conditions, of a camera that is a stack; where one is
/// not given, it is the one in the middle, which is said on standard error.
/// Throws Error(kUsage) as FixRequestedPointInRange(), and for cameras that are
/// no stack.
CameraInput ReadCamera(const std::string& path,
                       const RequestedOperatingPoint& at = {});
/// The camera in a file's bytes; path is used in errors. Says on standard error
/// what of another program's file was not taken as it stands.
CameraInput ParseCamera(const std::string& path, const std::string& bytes,
                        const RequestedOperatingPoint& at = {});

/// ReadCamera(), but over conditions that at does not give it stays a stack.
CameraInput ReadCameraOrStack(const std::string& path,
                              const RequestedOperatingPoint& at);

/// Reads two cameras, of which at is for those that are stacks. Values of
/// conditions that one of them does not change with are the other's, which is
/// said on standard error. Throws Error(kUsage) if neither does.
std::array<CameraInput, 2> ReadCameraPair(const std::string& first,
                                          const std::string& second,
                                          const RequestedOperatingPoint& at);

/// The cells in which a camera can be trusted, if its file or blob says so.
std::optional<ValidityMask> LoadValidityMask(const CameraInput& input);

/// The pixels that are to be shown of a camera's images with --outside OUTSIDE:
/// all, or those that are trusted. Throws Error(kUsage) if nothing says which
/// are.
std::optional<ValidityMask> SelectVisibleMask(const std::string& outside,
                                              const std::string& path,
                                              const CameraInput& input);

/// Says so on standard error if the camera's calibration failed, which results
/// do not show.
void WarnOfFailedCalibration(const std::string& path, const CameraFile& file);

/// Throws Error(kOutput) if pictures would be written among the images that
/// they are made from, where they would be taken for images the next time.
void RequireSeparateFolders(const std::vector<std::string>& images,
                            const std::string& folder);

/// Prints text, or writes it to a file if one is named.
void PrintOrWrite(const std::string& path, const std::string& text);

/// Rows of points or pixels that a command takes at once: those of an image of
/// full HD, or fewer if the answer is JSON. Its text is kept in memory, since
/// outputs appear whole or not at all.
inline size_t MaxRows(bool is_json) { return is_json ? 500000 : 2100000; }

/// A CSV of numbers as an array of objects, empty fields as null, a column
/// "valid" as true and false.
std::string ConvertCsvToJson(const std::string& csv,
                             const std::vector<std::string>& columns);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_CAMERA_INPUT_H
