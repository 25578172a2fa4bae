#include "dataset/held_stack.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <vector>

namespace raygrid {
namespace {

// Standard deviations with one condition held, which is removed from their
// values: interpolated between lattices of equal shape.
std::vector<StackDeviation> HoldOne(const std::vector<StackDeviation>& known,
                                    size_t range, double value) {
  std::map<ConditionValues, std::vector<const StackDeviation*>> by_others;
  for (const StackDeviation& deviation : known) {
    ConditionValues others = deviation.values;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(range));
    by_others[others].push_back(&deviation);
  }
  std::vector<StackDeviation> held;
  for (const auto& [others, line] : by_others) {
    // The ends of a range may have been rounded.
    const double inside = std::clamp(value, line.front()->values[range],
                                     line.back()->values[range]);
    for (size_t k = 1; k < line.size(); ++k) {
      const double low = line[k - 1]->values[range],
                   high = line[k]->values[range];
      const std::vector<double>& below = line[k - 1]->lattice.deviation_px;
      const std::vector<double>& above = line[k]->lattice.deviation_px;
      if (inside < low || inside > high || below.size() != above.size())
        continue;
      const double part = (inside - low) / (high - low);
      held.push_back({others, line[k]->lattice});
      for (size_t i = 0; i < below.size(); ++i)
        held.back().lattice.deviation_px[i] =
            (1 - part) * below[i] + part * above[i];
      break;
    }
  }
  return held;
}

std::vector<StackDeviation> HoldDeviations(std::vector<StackDeviation> known,
                                           const HeldConditions& at) {
  for (size_t r = at.size(); r-- > 0;)
    if (at[r]) known = HoldOne(known, r, *at[r]);
  return known;
}

HeldConditions AllHeld(const ConditionValues& values) {
  return {values.begin(), values.end()};
}

// Replaces a camera's standard deviations by those at another operating point.
void PutDeviations(const DeviationLattice& lattice, const Area& area,
                   CameraUncertainty* uncertainty) {
  if (lattice.deviation_px.size() != uncertainty->lattice.deviation_px.size())
    return;
  uncertainty->lattice = lattice;
  uncertainty->mask.DistrustAbove(uncertainty->max_deviation_px, lattice, area);
}

}  // namespace

StackOfCameras HoldStack(const StackOfCameras& stack,
                         const HeldConditions& at) {
  return {stack.cameras.Hold(at), HoldDeviations(stack.deviations, at)};
}

StackOfCameras StackAlong(const StackOfCameras& stack, size_t range) {
  HeldConditions at = AllHeld(stack.cameras.Middle());
  at[range].reset();
  return HoldStack(stack, at);
}

CameraFile FileAt(const CameraFile& stack, const HeldConditions& at) {
  CameraFile file = stack;
  const std::vector<ConditionRange>& ranges = stack.stack->cameras.ranges();
  StackOfCameras rest = HoldStack(*stack.stack, at);
  const ConditionValues middle = rest.cameras.Middle();
  CentralGeneric camera = rest.cameras.At(middle);
  camera.SetImageCircle(stack.camera->image_circle());
  file.camera = std::make_shared<CentralGeneric>(std::move(camera));
  if (file.uncertainty) {
    const std::vector<StackDeviation> known =
        HoldDeviations(rest.deviations, AllHeld(middle));
    if (known.size() == 1)
      PutDeviations(known[0].lattice, file.camera->area(), &*file.uncertainty);
  }
  if (!file.capture) file.capture.emplace();
  for (size_t r = 0; r < ranges.size(); ++r) {
    if (!at[r]) continue;
    if (ranges[r].condition == CameraCondition::kLensPosition)
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

std::optional<CameraUncertainty> UncertaintyOverRanges(
    const CameraFile& stack) {
  if (!stack.uncertainty) return std::nullopt;
  CameraUncertainty worst = *stack.uncertainty;
  DeviationLattice largest = worst.lattice;
  std::vector<double>& most = largest.deviation_px;
  for (const StackDeviation& known : stack.stack->deviations) {
    const std::vector<double>& there = known.lattice.deviation_px;
    if (there.size() != most.size()) continue;
    for (size_t i = 0; i < most.size(); ++i)
      // Undefined where one of them is NaN.
      if (!std::isnan(most[i]) && !(there[i] <= most[i])) most[i] = there[i];
  }
  PutDeviations(largest, stack.camera->area(), &worst);
  return worst;
}

}  // namespace raygrid
