#include "camera_statistics.h"

#include <unistd.h>

#include <cstdio>

namespace raygrid {
namespace {

unsigned long long Number(uint64_t count) { return count; }

double Rate(uint64_t frames, Clock::duration time) {
  const double seconds = std::chrono::duration<double>(time).count();
  return seconds > 0 ? static_cast<double>(frames) / seconds : 0;
}

}  // namespace

CameraStatistics::CameraStatistics(const CaptureGuard& capture, bool is_quiet)
    : capture_(capture),
      is_quiet_(is_quiet),
      is_terminal_(isatty(STDERR_FILENO) == 1),
      start_(Clock::now()),
      last_(start_) {}

void CameraStatistics::Count(const UndistortedFrame& frame) {
  waited_.Add(Clock::now() - frame.arrived - frame.remap_time);
}

void CameraStatistics::ShowPeriodically(const SourceCounts& source,
                                        const Undistorter& undistorter) {
  if (is_quiet_ || !is_terminal_) return;
  const Clock::time_point now = Clock::now();
  if (now - last_ < std::chrono::seconds(1)) return;
  const UndistorterStatistics statistics = undistorter.statistics();
  Show(source, statistics,
       Rate(statistics.undistorted - last_undistorted_, now - last_),
       "\x1b[K\r");
  last_ = now;
  last_undistorted_ = statistics.undistorted;
}

void CameraStatistics::ShowSummary(const SourceCounts& source,
                                   const Undistorter& undistorter) {
  if (is_quiet_) return;
  const UndistorterStatistics statistics = undistorter.statistics();
  Show(source, statistics, Rate(statistics.undistorted, Clock::now() - start_),
       is_terminal_ ? "\x1b[K\n" : "\n");
}

void CameraStatistics::Show(const SourceCounts& source,
                            const UndistorterStatistics& statistics,
                            double frames_per_second, const char* end) const {
  std::fprintf(
      stderr,
      "%.1f frames/s, remap %.2f ms (99 %%: %.2f ms), latency %.2f ms (99 %%: "
      "%.2f ms); %llu arrived, %llu undistorted, %llu delivered, %llu dropped, "
      "%llu damaged, %llu missed by the camera",
      frames_per_second, statistics.remap.Quantile_ms(0.5),
      statistics.remap.Quantile_ms(0.99), waited_.Quantile_ms(0.5),
      waited_.Quantile_ms(0.99), Number(source.arrived),
      Number(statistics.undistorted), Number(waited_.count()),
      Number(source.dropped + statistics.dropped), Number(source.damaged),
      Number(source.missed));
  if (!capture_.is_idle())
    std::fprintf(stderr, ", capture settings differ: %llu frames",
                 Number(capture_.num_not_as_calibrated()));
  if (capture_.num_held_back() > 0)
    std::fprintf(stderr, " (%llu held back)", Number(capture_.num_held_back()));
  const OperatingPointCounts& stack = statistics.stack;
  if (stack.num_missing > 0)
    std::fprintf(stderr, ", operating point unknown: %llu frames",
                 Number(stack.num_missing));
  if (stack.outside > 0)
    std::fprintf(stderr, ", operating point out of range: %llu frames",
                 Number(stack.outside));
  const FrameInfo& info = statistics.last_info;
  if (info.lens_position)
    std::fprintf(stderr, ", lens position %.2f dpt",
                 double{*info.lens_position});
  if (info.sensor_temperature_c)
    std::fprintf(stderr, ", sensor temperature %.1f °C",
                 double{*info.sensor_temperature_c});
  std::fputs(end, stderr);
}

}  // namespace raygrid
