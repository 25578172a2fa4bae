#include "calibration/divergence.h"

#include <algorithm>

#include "adjustment/reprojection_error.h"

namespace raygrid {
namespace {

size_t CountFeatures(const AdjustmentResult& adjusted) {
  size_t count = 0;
  for (const View& view : adjusted.problem.views)
    count += view.observations.size();
  for (const auto& rejected : adjusted.rejected_features)
    count += rejected.size();
  return count;
}

}  // namespace

double ErrorCapPx(const ImageSize& size) {
  constexpr double kRelativeCap = 1.0 / 128;
  return kRelativeCap * std::max(size.width, size.height);
}

double ComputeMeanErrorPx(const AdjustmentResult& adjusted,
                          const AdjustmentResult& start) {
  const double cap_px = ErrorCapPx(start.problem.image_sizes.front());
  double reduction_px = 0;  // sum of cap_px - error
  for (const Residual& residual :
       ComputeResiduals(adjusted.state, adjusted.problem.views, 1))
    if (residual.valid)
      reduction_px += cap_px - std::min(residual.error_px.norm(), cap_px);
  // The error of rejected features that could not be projected is stored as
  // zero.
  for (const auto& rejected : adjusted.rejected_features)
    for (const FeatureResidual& residual : rejected)
      if (!residual.error_px.isZero(0))
        reduction_px += cap_px - std::min(residual.error_px.norm(), cap_px);
  const auto count = static_cast<double>(CountFeatures(start));
  return cap_px - reduction_px / std::max(1.0, count);
}

bool ExceedsDivergenceRatio(double error_px, double other_px) {
  constexpr double kNegligiblePx = 0.01;
  return error_px > kDivergenceRatio * other_px + kNegligiblePx;
}

bool HasDiverged(const AdjustmentResult& adjusted,
                 const AdjustmentResult& start) {
  return ExceedsDivergenceRatio(ComputeMeanErrorPx(adjusted, start),
                                ComputeMeanErrorPx(start, start));
}

}  // namespace raygrid
