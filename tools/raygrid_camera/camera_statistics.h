#ifndef RAYGRID_CAMERA_CAMERA_STATISTICS_H
#define RAYGRID_CAMERA_CAMERA_STATISTICS_H

#include <cstdint>

#include "capture_guard.h"
#include "frame_source.h"
#include "undistorter.h"

namespace raygrid {

/// Says on standard error how it goes: on a terminal once a second, and at the
/// end.
class CameraStatistics {
 public:
  /// capture  outlives it
  CameraStatistics(const CaptureGuard& capture, bool is_quiet);
  /// A frame that was taken to be written.
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
  DurationHistogram waited_;  // from arrival on, without the remap
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_STATISTICS_H
