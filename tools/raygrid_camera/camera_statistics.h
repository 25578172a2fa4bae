#ifndef RAYGRID_CAMERA_CAMERA_STATISTICS_H
#define RAYGRID_CAMERA_CAMERA_STATISTICS_H

#include <cstdint>

#include "capture_guard.h"
#include "frame_source.h"
#include "undistorter.h"

namespace raygrid {

/// Prints statistics on standard error: once a second if it is a terminal, and
/// at the end.
class CameraStatistics {
 public:
  /// capture  must outlive this object
  CameraStatistics(const CaptureGuard& capture, bool is_quiet);
  /// Counts a frame that is used for output.
  void Count(const UndistortedFrame& frame);
  void ShowPeriodically(const SourceCounts& source,
                        const Undistorter& undistorter);
  void ShowSummary(const SourceCounts& source, const Undistorter& undistorter);

 private:
  void Show(const SourceCounts& source, const UndistorterStatistics& statistics,
            double frames_per_second, const char* end) const;

  const CaptureGuard& capture_;
  const bool is_quiet_, is_terminal_;
  const Clock::time_point start_;
  Clock::time_point last_;
  uint64_t last_undistorted_ = 0;
  DurationHistogram waited_;  // time since arrival, without the remap
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_STATISTICS_H
