#ifndef RAYGRID_CALIBRATION_STOPWATCH_H
#define RAYGRID_CALIBRATION_STOPWATCH_H

#include <chrono>

namespace raygrid {

/// Adds its lifetime in seconds to a variable.
class Stopwatch {
 public:
  explicit Stopwatch(double* seconds) : seconds_(seconds) {}
  ~Stopwatch() {
    *seconds_ += std::chrono::duration<double>(Clock::now() - start_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  double* seconds_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_STOPWATCH_H
