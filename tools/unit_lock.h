#ifndef RAYGRID_TOOLS_UNIT_LOCK_H
#define RAYGRID_TOOLS_UNIT_LOCK_H

#include <string>

namespace raygrid {

/// Exclusive access to a unit, also across machines that share a folder. Locks
/// a byte of .batch.lock in the folder, until the process ends.
class UnitLock {
 public:
  /// Waits until no other process holds the lock. File systems without locks
  /// are assumed not to be shared. Throws Error(kOutputFailed) if the file
  /// cannot be created.
  UnitLock(const std::string& folder, const std::string& serial);
  ~UnitLock();
  UnitLock(const UnitLock&) = delete;
  UnitLock& operator=(const UnitLock&) = delete;

 private:
  int file_;
};

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_UNIT_LOCK_H
