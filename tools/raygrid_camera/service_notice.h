#ifndef RAYGRID_CAMERA_SERVICE_NOTICE_H
#define RAYGRID_CAMERA_SERVICE_NOTICE_H

#include "frame_source.h"

namespace raygrid {

/// Notifies systemd of processed frames. No effect if systemd did not start the
/// program, or without libsystemd.
class ServiceNotice {
 public:
  ServiceNotice();
  /// Called after the output of a frame. The first call reports the service as
  /// ready, and each call feeds systemd's watchdog.
  void OnFrame();

 private:
  bool is_ready_ = false;
  const Clock::duration interval_;  // between notifications; 0: none
  Clock::time_point next_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_SERVICE_NOTICE_H
