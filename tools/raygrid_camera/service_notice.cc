#include "service_notice.h"

#if RAYGRID_HAS_SYSTEMD
#include <systemd/sd-daemon.h>

#include <cstdint>
#endif

namespace raygrid {
namespace {

// The number of notifications per watchdog interval. More are unnecessary, and
// each costs a system call and work in systemd.
constexpr int kNoticesInTime = 4;

#if RAYGRID_HAS_SYSTEMD

// Returns the timeout of systemd's watchdog; 0 if it is disabled.
std::chrono::microseconds WatchdogTime() {
  uint64_t time_us = 0;
  if (sd_watchdog_enabled(0, &time_us) <= 0) time_us = 0;
  return std::chrono::microseconds(time_us);
}

void NotifySystemd(const char* word) { sd_notify(0, word); }

#else

std::chrono::microseconds WatchdogTime() {
  return std::chrono::microseconds(0);
}

void NotifySystemd(const char*) {}

#endif

}  // namespace

ServiceNotice::ServiceNotice() : interval_(WatchdogTime() / kNoticesInTime) {}

void ServiceNotice::OnFrame() {
  if (!is_ready_) NotifySystemd("READY=1");
  is_ready_ = true;
  const Clock::time_point now = Clock::now();
  if (interval_.count() == 0 || now < next_) return;
  NotifySystemd("WATCHDOG=1");
  next_ = now + interval_;
}

}  // namespace raygrid
