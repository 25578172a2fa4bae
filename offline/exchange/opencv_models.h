/// OpenCV's camera models, as identified in its files.
#ifndef RAYGRID_EXCHANGE_OPENCV_MODELS_H
#define RAYGRID_EXCHANGE_OPENCV_MODELS_H

#include <string>
#include <vector>

#include "exchange/format.h"
#include "exchange/opencv_keys.h"

namespace raygrid {
namespace opencv_file {

constexpr char kFisheye[] = "fisheye", kOmnidir[] = "omnidir";

/// Pinholes with 4, 5, 8, 12 and 14 coefficients, the fisheye, and omnidir,
/// whose xi has a separate key.
const std::vector<ExternalModel>& GetOpenCvModels();

/// Determines the external model from the file, otherwise from the user's
/// option, or else from the number of coefficients. Removes trailing zeros that
/// the model does not have. Throws InputError.
const ExternalModel& DetermineModel(const CameraKeys& keys,
                                    const Affixes& affixes,
                                    const ReadRequest& request, double skew_px,
                                    DistortionCoefficients* coefficients,
                                    std::vector<std::string>* warnings);

}  // namespace opencv_file
}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OPENCV_MODELS_H
