/// Alternative key names in files of OpenCV, its programs and their users.
#ifndef RAYGRID_EXCHANGE_OPENCV_KEYS_H
#define RAYGRID_EXCHANGE_OPENCV_KEYS_H

#include <array>
#include <string>
#include <vector>

#include "exchange/camera_keys.h"
#include "exchange/external_model.h"

namespace raygrid {
namespace opencv_file {

using KeyList = std::vector<std::string>;

/// Keys of the camera matrix, and of the distortion coefficients.
extern const KeyList kMatrixKeys, kDistortionKeys;
/// Keys of the camera's name, its model, and a fisheye flag.
extern const KeyList kNameKeys, kModelKeys, kFisheyeKeys;
/// Keys without intrinsics, and keys with another meaning in other formats.
extern const KeyList kOtherKeys, kVagueKeys;

/// Prefix and suffix of a camera's keys in a file of several cameras.
struct Affixes {
  std::string prefix, suffix, camera;
};

/// Returns the prefix and suffix of each camera's keys in a file of several
/// cameras; empty if no camera-matrix key has a prefix or suffix.
std::vector<Affixes> FindCameraAffixes(const CameraKeys& keys);

/// Returns the first of these keys that exists, or "".
std::string FindKey(const CameraKeys& keys, const KeyList& names,
                    const Affixes& affixes = {});

/// Returns the text at the first of these keys, or "".
std::string GetKeyText(const CameraKeys& keys, const KeyList& names);

/// Returns whether there is a camera matrix, or fx, fy, cx, cy.
bool HasMatrix(const CameraKeys& keys, const Affixes& affixes = {});

/// Returns 0 x 0 if the file has no image size. Throws InputError.
ImageSize ReadImageSize(const CameraKeys& keys, const Affixes& affixes);

/// Sets fx, fy, cx, cy and skew from the camera matrix. Throws InputError.
void ReadIntrinsics(const CameraKeys& keys, const Affixes& affixes,
                    ConvertedCamera* lens);

/// Distortion coefficients; whether they are a column of four, as written by
/// cv::fisheye (cv::calibrateCamera() has five or more), and whether their keys
/// belong to a fisheye.
struct DistortionCoefficients {
  std::vector<double> numbers;
  bool is_fisheye_column = false, has_fisheye_names = false;
};
DistortionCoefficients Coefficients(const CameraKeys& keys,
                                    const Affixes& affixes);

/// Returns whether there are distortion coefficients, as a vector or by names
/// such as k1.
bool HasCoefficients(const CameraKeys& keys, const Affixes& affixes = {});

}  // namespace opencv_file
}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OPENCV_KEYS_H
