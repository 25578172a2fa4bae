#ifndef RAYGRID_TOOLS_PROGRESS_BAR_H
#define RAYGRID_TOOLS_PROGRESS_BAR_H

#include <chrono>
#include <string>

namespace raygrid {

/// A progress bar with the remaining time on stderr, if it is a terminal.
class ProgressBar {
 public:
  explicit ProgressBar(bool quiet);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// done: fraction from 0 to 1
  void Show(const std::string& stage, double done);

 private:
  using Clock = std::chrono::steady_clock;
  bool visible_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_PROGRESS_BAR_H
