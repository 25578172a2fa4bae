#include "state_lock.h"

#include <cstdio>

namespace raygrid {

StateLock MakeUnlockedState(const std::string& reason) {
  StateLock lock;
  for (const char* subject : {"focus", "exposure", "gain", "white balance"})
    lock.open.push_back(std::string(subject) + ": " + reason);
  return lock;
}

std::string DescribeExposure(double exposure_us) {
  const double exposure_ms = exposure_us / 1000;
  char text[64];
  std::snprintf(text, sizeof(text), "exposure %.*f ms", exposure_ms < 1 ? 2 : 1,
                exposure_ms);
  return text;
}

}  // namespace raygrid
