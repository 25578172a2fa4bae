#ifndef RAYGRID_CALIBRATION_UNCERTAINTY_ESTIMATION_H
#define RAYGRID_CALIBRATION_UNCERTAINTY_ESTIMATION_H

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "calibration/model_adjustment.h"
#include "camera/camera_uncertainty.h"
#include "evaluation/uncertainty_summary.h"

namespace raygrid {

/// Returns the default limit of the valid region: max(0.25 px, 3 sigma of the
/// feature noise).
double DefaultValidLimitPx(double noise_px);

/// The predicted uncertainty and the extrapolated region of an adjusted camera.
struct EstimatedUncertainty {
  CameraUncertainty uncertainty;
  ExtrapolatedRegion extrapolated;
};

/// Estimates the uncertainty of an adjusted camera (adjustment/covariance.h).
/// The valid region has features nearby and a standard deviation, including
/// directions left free by the prior, below the limit (default:
/// DefaultValidLimitPx()). The returned standard deviations include only noise
/// where the data determine the camera, and all contributions elsewhere. They
/// are doubled in the extrapolated region. Returns nullopt if the normal
/// equations are singular or the adjustment ended before it estimated the
/// noise.
std::optional<EstimatedUncertainty> EstimateUncertainty(
    const AdjustmentResult& adjusted, int camera,
    const std::optional<ImageCircle>& image_circle,
    const std::optional<double>& valid_limit_px, int num_threads);

/// Estimates the standard deviations of a camera at each of several cameras
/// with the same parameters (samples of an operating-point model), due to noise
/// and smoothing. Empty if the equations are singular.
std::vector<UncertaintyLattice> EstimateStdDevs(
    const AdjustmentResult& adjusted, int camera,
    const std::vector<const CameraModel*>& as, int num_threads);

/// Predicts the held-out errors of images if the camera were calibrated without
/// all of these images: for each image the median over its features of the
/// standard deviation of a held-out residual (both coordinates), in pixels,
/// from the equations of the adjustment. Empty if they take too long to solve.
std::map<std::string, double> PredictHeldOutStdDevs(
    const AdjustmentResult& adjusted, int camera,
    const std::set<std::string>& images, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_UNCERTAINTY_ESTIMATION_H
