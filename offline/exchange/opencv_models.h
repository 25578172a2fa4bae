/// Camera models of OpenCV, as its files say them.
#ifndef RAYGRID_EXCHANGE_OPENCV_MODELS_H
#define RAYGRID_EXCHANGE_OPENCV_MODELS_H

#include <string>
#include <vector>

#include "exchange/format.h"
#include "exchange/opencv_keys.h"

namespace raygrid {
namespace opencv_file {

constexpr char kFisheye[] = "fisheye", kOmnidir[] = "omnidir";

/// Pinholes of 4, 5, 8, 12 and 14 coefficients, the fisheye and omnidir, whose
/// xi stands in a key of its own.
const std::vector<LensForm>& OpenCvForms();

/// The form of what the file says, or else the user; or else of the number of
/// coefficients. Takes zeros off these that the form has no place for. Throws
/// InputError.
const LensForm& DetermineForm(const CameraKeys& keys, const Affixes& affixes,
                              const ReadRequest& request, double skew_px,
                              DistortionCoefficients* coefficients,
                              std::vector<std::string>* warnings);

}  // namespace opencv_file
}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OPENCV_MODELS_H
