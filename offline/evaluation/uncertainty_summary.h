/// Where a camera is valid, and its predicted uncertainty as shares of the
/// image.
#ifndef RAYGRID_EVALUATION_UNCERTAINTY_SUMMARY_H
#define RAYGRID_EVALUATION_UNCERTAINTY_SUMMARY_H

#include <array>
#include <optional>
#include <string>

#include "camera/camera_model.h"
#include "camera/camera_uncertainty.h"
#include "camera/image_circle.h"

namespace raygrid {

/// The part of the image that no features support.
struct ExtrapolatedRegion {
  double share = 0;  ///< of the image, or of its image circle
  /// The predicted uncertainty that 95 % of the region is below, 1 sigma.
  double p95_px = 0;
  std::string where;  ///< "corners", "left edge and top right corner", ...
};

/// The limits, in pixels, of the shares that are stated.
constexpr std::array<double, 5> kShareLimitsPx = {0.05, 0.1, 0.2, 0.5, 1};

/// Predicted uncertainty over the image. Shares are of the pixels of the image,
/// or of its image circle where the camera has one.
struct UncertaintySummary {
  double median_px = 0;
  std::array<double, kShareLimitsPx.size()> share_below = {};
  double valid_share = 0;
};

UncertaintySummary SummarizeUncertainty(const CameraModel& camera,
                                        const CameraUncertainty& uncertainty);
/// UncertaintySummary's share of the valid region alone.
double ValidShare(const CameraModel& camera, const TrustMask& valid);

/// "83 % of the image is valid: supported by features, and predicted to better
/// than 0.25 px".
std::string UncertaintySentence(const UncertaintySummary& summary,
                                const CameraUncertainty& uncertainty,
                                const CameraModel& camera);

/// The extrapolated region: cells of the area that are not supported by
/// features.
ExtrapolatedRegion FindExtrapolatedRegion(
    const CameraModel& camera, const std::optional<ImageCircle>& image_circle,
    const TrustMask& supported, const DeviationLattice& lattice);

/// Makes cells invalid that do not lie within the circle as a whole.
void InvalidateBeyond(const ImageCircle& circle, TrustMask* mask);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_UNCERTAINTY_SUMMARY_H
