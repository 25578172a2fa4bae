#ifndef RAYGRID_CAMERA_SERVICE_NOTICE_H
#define RAYGRID_CAMERA_SERVICE_NOTICE_H

#include "frame_source.h"

namespace raygrid {

/// Tells systemd that frames pass. Does nothing where systemd did not start the
/// program, or libsystemd is not built in.
class ServiceNotice {
 public:
  ServiceNotice();
  /// A frame was undistorted and went where it was to go. The first one makes
  /// the service ready, and each says to systemd's watchdog that it lives.
  void OnFrame();

 private:
  bool is_ready_ = false;
  const Clock::duration interval_;  // between words to the watchdog; 0: none
  Clock::time_point next_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_SERVICE_NOTICE_H
