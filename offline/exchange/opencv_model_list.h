/// Camera models that several programs share with OpenCV.
#ifndef RAYGRID_EXCHANGE_OPENCV_MODEL_LIST_H
#define RAYGRID_EXCHANGE_OPENCV_MODEL_LIST_H

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "dataset/error.h"
#include "exchange/external_model.h"

namespace raygrid {

/// OpenCV's pinhole with its first `count` coefficients: k1, k2, p1, p2, k3,
/// k4, k5, k6, s1, s2, s3, s4, tx, ty. count is 0, 4, 5, 8, 12 or 14.
inline ExternalModel MakeOpenCvModel(const std::string& name, int count) {
  const std::vector<std::string> all = {"k1", "k2", "p1", "p2", "k3",
                                        "k4", "k5", "k6", "s1", "s2",
                                        "s3", "s4", "tx", "ty"};
  ExternalModel external_model =
      MakeExternalModel(name, count > 8 ? models::kOpenCv14 : models::kOpenCv,
                        {all.begin(), all.begin() + count});
  external_model.max_supported_angle_rad = M_PI / 2;
  return external_model;
}

/// OpenCV's fisheye (equidistant) with k1, k2, k3, k4. OpenCV divides by z, so
/// it is limited to the half space in front of the camera.
inline ExternalModel MakeOpenCvFisheyeModel(const std::string& name) {
  ExternalModel external_model = MakeExternalModel(
      name, models::kThinPrismFisheye, {"k1", "k2", "k3", "k4"});
  external_model.max_supported_angle_rad = M_PI / 2;
  return external_model;
}

/// Sets fx, fy, cx, cy and the skew from a camera matrix, row-major, or
/// column-major as in MATLAB, Open3D and Apple's formats. Throws InputError
/// with the name for a matrix other than [fx s cx; 0 fy cy; 0 0 1].
inline void ReadCameraMatrix(std::vector<double> k, const std::string& name,
                             ConvertedCamera* lens) {
  if (k.size() != 9) throw InputError(fmt::format("{}: not 3 x 3", name));
  if (k[2] == 0 && k[5] == 0 && k[6] != 0 && k[7] != 0)
    k = {k[0], k[3], k[6], k[1], k[4], k[7], k[2], k[5], k[8]};
  if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    throw InputError(
        fmt::format("{}: expected the form fx s cx, 0 fy cy, 0 0 1", name));
  lens->values = {k[0], k[4], k[2], k[5]};
  lens->skew_px = k[1];
}

/// Truncates coefficients in OpenCV's order to `count` if all further ones are
/// 0.
inline void TrimCoefficients(size_t count, std::vector<double>* coefficients) {
  const auto is_zero_from = [&](size_t first) {
    return std::all_of(
        coefficients->begin() + static_cast<std::ptrdiff_t>(first),
        coefficients->end(), [](double number) { return number == 0; });
  };
  if (coefficients->size() > count && is_zero_from(count))
    coefficients->resize(count);
}

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OPENCV_MODEL_LIST_H
