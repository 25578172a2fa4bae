#include "progress_bar.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace raygrid {

ProgressBar::ProgressBar(bool quiet)
    : visible_(!quiet && isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() {
  if (visible_) fmt::print(stderr, "\r\033[K");
}

void ProgressBar::Show(const std::string& stage, double done) {
  if (!visible_) return;
  done = done >= 0 ? std::min(done, 1.0) : 0;  // NaN, too
  constexpr int kWidth = 30;
  const int filled = static_cast<int>(std::lround(kWidth * done));
  const double elapsed =
      std::chrono::duration<double>(Clock::now() - start_).count();
  std::string left;
  if (done > 0.02)
    left = fmt::format("{:.0f} s left", elapsed * (1 - done) / done);
  fmt::print(stderr, "\r\033[K{:<18} [{}{}] {:3.0f} % {}", stage,
             std::string(filled, '#'), std::string(kWidth - filled, ' '),
             100 * done, left);
  std::fflush(stderr);
}

}  // namespace raygrid
