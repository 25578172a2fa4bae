#ifndef RAYGRID_CALIBRATION_STOPWATCH_H
#define RAYGRID_CALIBRATION_STOPWATCH_H

#include <chrono>

namespace raygrid {

class Stopwatch {
 public:
  double Seconds() const {
    return std::chrono::duration<double>(Clock::now() - start_).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_STOPWATCH_H
