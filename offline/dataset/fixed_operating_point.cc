#include "dataset/fixed_operating_point.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <vector>

namespace raygrid {
namespace {

// Fixes one parameter of the operating point: interpolates the standard
// deviations linearly between samples with equal lattices, and removes the
// parameter from their operating points.
std::vector<OperatingPointUncertainty> FixParameter(
    const std::vector<OperatingPointUncertainty>& known, size_t range,
    double value) {
  std::map<OperatingPoint, std::vector<const OperatingPointUncertainty*>>
      by_others;
  for (const OperatingPointUncertainty& deviation : known) {
    OperatingPoint others = deviation.values;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(range));
    by_others[others].push_back(&deviation);
  }
  std::vector<OperatingPointUncertainty> held;
  for (const auto& [others, line] : by_others) {
    // The value may be outside the range by rounding.
    const double inside = std::clamp(value, line.front()->values[range],
                                     line.back()->values[range]);
    for (size_t k = 1; k < line.size(); ++k) {
      const double low = line[k - 1]->values[range],
                   high = line[k]->values[range];
      const std::vector<double>& below = line[k - 1]->lattice.stddev_px;
      const std::vector<double>& above = line[k]->lattice.stddev_px;
      if (inside < low || inside > high || below.size() != above.size())
        continue;
      const double part = (inside - low) / (high - low);
      held.push_back({others, line[k]->lattice});
      for (size_t i = 0; i < below.size(); ++i)
        held.back().lattice.stddev_px[i] =
            (1 - part) * below[i] + part * above[i];
      break;
    }
  }
  return held;
}

std::vector<OperatingPointUncertainty> FixParameterInStdDevs(
    std::vector<OperatingPointUncertainty> known,
    const FixedOperatingPoint& at) {
  for (size_t r = at.size(); r-- > 0;)
    if (at[r]) known = FixParameter(known, r, *at[r]);
  return known;
}

FixedOperatingPoint FixAllParameters(const OperatingPoint& values) {
  return {values.begin(), values.end()};
}

// Replaces a camera's standard deviations by those at another operating point.
void ReplaceStdDevs(const UncertaintyLattice& lattice, const Area& area,
                    CameraUncertainty* uncertainty) {
  if (lattice.stddev_px.size() != uncertainty->lattice.stddev_px.size()) return;
  uncertainty->lattice = lattice;
  uncertainty->mask.InvalidateAbove(uncertainty->max_stddev_px, lattice, area);
}

}  // namespace

OperatingPointCalibration FixOperatingPoint(
    const OperatingPointCalibration& stack, const FixedOperatingPoint& at) {
  return {stack.cameras.FixValues(at),
          FixParameterInStdDevs(stack.deviations, at)};
}

OperatingPointCalibration SliceOperatingPointModel(
    const OperatingPointCalibration& stack, size_t range) {
  FixedOperatingPoint at = FixAllParameters(stack.cameras.Center());
  at[range].reset();
  return FixOperatingPoint(stack, at);
}

CameraFile MakeCameraFileAt(const CameraFile& stack,
                            const FixedOperatingPoint& at) {
  CameraFile file = stack;
  const std::vector<OperatingRange>& ranges = stack.stack->cameras.ranges();
  OperatingPointCalibration rest = FixOperatingPoint(*stack.stack, at);
  const OperatingPoint center = rest.cameras.Center();
  CentralGeneric camera = rest.cameras.At(center);
  camera.SetImageCircle(stack.camera->image_circle());
  file.camera = std::make_shared<CentralGeneric>(std::move(camera));
  if (file.uncertainty) {
    const std::vector<OperatingPointUncertainty> known =
        FixParameterInStdDevs(rest.deviations, FixAllParameters(center));
    if (known.size() == 1)
      ReplaceStdDevs(known[0].lattice, file.camera->area(), &*file.uncertainty);
  }
  if (!file.capture) file.capture.emplace();
  for (size_t r = 0; r < ranges.size(); ++r) {
    if (!at[r]) continue;
    if (ranges[r].condition == OperatingParameter::kLensPosition)
      file.capture->lens_position = at[r];
    else
      file.capture->sensor_temperature_c = at[r];
  }
  if (rest.cameras.ranges().empty())
    file.stack.reset();
  else
    file.stack = std::move(rest);
  return file;
}

std::optional<CameraUncertainty> ComputeMaxUncertainty(
    const CameraFile& stack) {
  if (!stack.uncertainty) return std::nullopt;
  CameraUncertainty worst = *stack.uncertainty;
  UncertaintyLattice largest = worst.lattice;
  std::vector<double>& most = largest.stddev_px;
  for (const OperatingPointUncertainty& known : stack.stack->deviations) {
    const std::vector<double>& there = known.lattice.stddev_px;
    if (there.size() != most.size()) continue;
    for (size_t i = 0; i < most.size(); ++i)
      // The maximum is NaN where any of the values is NaN.
      if (!std::isnan(most[i]) && !(there[i] <= most[i])) most[i] = there[i];
  }
  ReplaceStdDevs(largest, stack.camera->area(), &worst);
  return worst;
}

}  // namespace raygrid
