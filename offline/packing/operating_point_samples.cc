#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "dataset/error.h"
#include "packing/pack.h"

namespace raygrid {
namespace {

// Returns the maximum error in pixels of interpolating between two cameras,
// compared to a third one, over a grid of its area.
double BlendError(const CentralGeneric& lower, const CentralGeneric& upper,
                  double weight, const CentralGeneric& truth) {
  constexpr int kSteps = 24;
  const Area& area = truth.area();
  double worst = 0;
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const Eigen::Vector2d pixel(area.x0 + area.width() * i / kSteps,
                                  area.y0 + area.height() * j / kSteps);
      Eigen::Matrix2d slope;
      const Eigen::Vector2d chart = truth.surface().Evaluate(pixel, &slope);
      const Eigen::Vector2d blend =
          (1 - weight) * lower.surface().Evaluate(pixel) +
          weight * upper.surface().Evaluate(pixel);
      // Converts chart positions to pixels by the local Jacobian.
      const Eigen::Matrix2d inverse = slope.inverse();
      if (inverse.allFinite())
        worst = std::max(worst, (inverse * (blend - chart)).norm());
    }
  }
  return worst;
}

// Makes evenly spaced samples; nullopt if they exceed the error limit.
std::optional<OperatingPointSamples> MakeSamples(
    int num_samples, double low, double high,
    const std::function<CentralGeneric(double)>& camera_at,
    double max_error_px) {
  OperatingPointSamples stack;
  for (int k = 0; k < num_samples; ++k) {
    stack.values.push_back(low + (high - low) * k / (num_samples - 1));
    stack.cameras.push_back(camera_at(stack.values.back()));
  }
  for (int k = 0; k + 1 < num_samples; ++k)
    for (const double weight : {0.25, 0.5, 0.75}) {
      const double value =
          stack.values[k] + weight * (stack.values[k + 1] - stack.values[k]);
      if (BlendError(stack.cameras[k], stack.cameras[k + 1], weight,
                     camera_at(value)) > max_error_px)
        return std::nullopt;
    }
  return stack;
}

}  // namespace

OperatingPointSamples MakeModelSamples(const OperatingPointModel& stack) {
  const OperatingRange& range = stack.ranges()[0];
  return SelectSamples(range.condition == OperatingParameter::kLensPosition
                           ? RG_OPERATING_PARAMETER_LENS_POSITION
                           : RG_OPERATING_PARAMETER_TEMPERATURE,
                       range.low, range.high,
                       [&](double value) { return stack.At({value}); });
}

OperatingPointSamples SelectSamples(
    rg_operating_parameter condition, double low, double high,
    const std::function<CentralGeneric(double)>& camera_at,
    double max_error_px) {
  for (int num_samples = RG_MIN_STACK_SAMPLES;
       num_samples <= static_cast<int>(RG_MAX_STACK_SAMPLES); ++num_samples) {
    std::optional<OperatingPointSamples> stack =
        MakeSamples(num_samples, low, high, camera_at, max_error_px);
    if (!stack) continue;
    stack->condition = condition;
    return *std::move(stack);
  }
  throw Error(ExitCode::kQualityTooLow,
              fmt::format("{} samples, the maximum, cannot represent the "
                          "camera from {} to {} within {} px; reduce the range",
                          RG_MAX_STACK_SAMPLES, low, high, max_error_px));
}

}  // namespace raygrid
