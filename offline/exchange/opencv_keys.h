/// The names that files of OpenCV, its programs and their users give to one
/// thing.
#ifndef RAYGRID_EXCHANGE_OPENCV_KEYS_H
#define RAYGRID_EXCHANGE_OPENCV_KEYS_H

#include <array>
#include <string>
#include <vector>

#include "exchange/camera_keys.h"
#include "exchange/lens_form.h"

namespace raygrid {
namespace opencv_file {

using KeyList = std::vector<std::string>;

/// Names of the camera matrix, and of the distortion coefficients.
extern const KeyList kMatrixKeys, kDistortionKeys;
/// Names of the camera, of its model, and of a flag that it is a fisheye.
extern const KeyList kNameKeys, kModelKeys, kFisheyeKeys;
/// Keys that say nothing of the lens, and those that mean something else in
/// other formats.
extern const KeyList kOtherKeys, kVagueKeys;

/// Texts before and behind the names of keys of one camera of several.
struct Affixes {
  std::string before, behind, camera;
};

/// The affixes of a file of several cameras; none if it has no matrices of
/// these.
std::vector<Affixes> FindCameras(const CameraKeys& keys);

/// The first of these keys that stands in a map, or "".
std::string FindKey(const CameraKeys& keys, const KeyList& names,
                    const Affixes& affixes = {});

/// The text at the first of these keys, or "".
std::string TextAt(const CameraKeys& keys, const KeyList& names);

/// Whether a map has a camera matrix, or its four numbers.
bool HasMatrix(const CameraKeys& keys, const Affixes& affixes = {});

/// 0 x 0 if the file does not say it. Throws InputError.
ImageSize ReadImageSize(const CameraKeys& keys, const Affixes& affixes);

/// Sets the values and the skew of a lens by its matrix. Throws InputError.
void ReadIntrinsics(const CameraKeys& keys, const Affixes& affixes,
                    ConvertedLens* lens);

/// Distortion coefficients, and whether they are a column of four, as
/// cv::fisheye writes them (cv::calibrateCamera() has five or more), or have
/// the names of a fisheye's.
struct DistortionCoefficients {
  std::vector<double> numbers;
  bool is_fisheye_column = false, has_fisheye_names = false;
};
DistortionCoefficients Coefficients(const CameraKeys& keys,
                                    const Affixes& affixes);
bool HasCoefficients(const CameraKeys& keys, const Affixes& affixes = {});

}  // namespace opencv_file
}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OPENCV_KEYS_H
