#ifndef RAYGRID_LIBCAMERA_DURATION_HISTOGRAM_H
#define RAYGRID_LIBCAMERA_DURATION_HISTOGRAM_H

#include <array>
#include <chrono>
#include <cstdint>

namespace raygrid {

/// A histogram of durations in steps of 2 %, from a microsecond to an hour.
class DurationHistogram {
 public:
  void Add(std::chrono::nanoseconds duration);
  uint64_t count() const { return count_; }
  /// Returns a quantile of the durations in milliseconds, for a fraction from 0
  /// to 1; 0 without durations.
  double Quantile_ms(double part) const;

 private:
  static constexpr int kStepsPerOctave = 32, kNumSteps = 1024;
  std::array<uint32_t, kNumSteps> counts_ = {};
  uint64_t count_ = 0;
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_DURATION_HISTOGRAM_H
