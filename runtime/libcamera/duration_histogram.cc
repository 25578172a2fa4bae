#include "duration_histogram.h"

#include <algorithm>
#include <cmath>

namespace raygrid {

void DurationHistogram::Add(std::chrono::nanoseconds duration) {
  const double microseconds = std::max(1e-3 * duration.count(), 1.0);
  const int step =
      static_cast<int>(std::ceil(kStepsPerOctave * std::log2(microseconds)));
  ++counts_[std::min(step, kNumSteps - 1)];
  ++count_;
}

double DurationHistogram::Quantile_ms(double part) const {
  const double wanted = std::ceil(part * static_cast<double>(count_));
  uint64_t seen = 0;
  for (int step = 0; step < kNumSteps; ++step) {
    seen += counts_[step];
    if (seen > 0 && static_cast<double>(seen) >= wanted)
      return 1e-3 * std::exp2(static_cast<double>(step) / kStepsPerOctave);
  }
  return 0;
}

}  // namespace raygrid
