/// The valid region, and the predicted uncertainty over the image.
#ifndef RAYGRID_EVALUATION_UNCERTAINTY_SUMMARY_H
#define RAYGRID_EVALUATION_UNCERTAINTY_SUMMARY_H

#include <array>
#include <optional>
#include <string>

#include "camera/camera_model.h"
#include "camera/camera_uncertainty.h"
#include "camera/image_circle.h"

namespace raygrid {

/// The extrapolated part of the image.
struct ExtrapolatedRegion {
  double share = 0;  ///< fraction of the image, or of its image circle
  /// The 95 % quantile of the predicted uncertainty there, 1 sigma.
  double p95_px = 0;
  std::string
      image_regions;  ///< "corners", "left edge and top right corner", ...
};

/// Limits of the predicted uncertainty (px) for which shares are reported.
constexpr std::array<double, 5> kShareLimitsPx = {0.05, 0.1, 0.2, 0.5, 1};

/// Predicted uncertainty over the image. Shares are fractions of the image's
/// pixels, or of its image circle.
struct UncertaintySummary {
  double median_px = 0;
  std::array<double, kShareLimitsPx.size()> share_below = {};
  double valid_share = 0;
};

UncertaintySummary SummarizeUncertainty(const CameraModel& camera,
                                        const CameraUncertainty& uncertainty);
/// Returns the fraction of valid pixels, as in UncertaintySummary.
double ComputeValidShare(const CameraModel& camera, const ValidityMask& valid);

/// Formats "83 % of the image is valid: supported by features, with a predicted
/// uncertainty below 0.25 px.".
std::string DescribeUncertainty(const UncertaintySummary& summary,
                                const CameraUncertainty& uncertainty,
                                const CameraModel& camera);

/// Finds the extrapolated region: cells of the area without nearby features.
ExtrapolatedRegion SummarizeExtrapolatedRegion(
    const CameraModel& camera, const std::optional<ImageCircle>& image_circle,
    const ValidityMask& supported, const UncertaintyLattice& lattice);

/// Invalidates cells that are not completely within the image circle.
void InvalidateOutside(const ImageCircle& circle, ValidityMask* mask);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_UNCERTAINTY_SUMMARY_H
