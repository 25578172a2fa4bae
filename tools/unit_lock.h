#ifndef RAYGRID_TOOLS_UNIT_LOCK_H
#define RAYGRID_TOOLS_UNIT_LOCK_H

#include <string>

namespace raygrid {

/// A unit that one process at a time works on, also of several machines that
/// share a folder. The lock is a byte of .batch.lock in the folder, and ends
/// with the process.
class UnitLock {
 public:
  /// Waits until no other process has it. A file system without locks is taken
  /// as one that nobody shares. Throws Error(kOutput) if the file cannot be
  /// made.
  UnitLock(const std::string& folder, const std::string& serial);
  ~UnitLock();
  UnitLock(const UnitLock&) = delete;
  UnitLock& operator=(const UnitLock&) = delete;

 private:
  int file_;
};

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_UNIT_LOCK_H
