#include "unit_lock.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

#include "dataset/content_hash.h"
#include "dataset/files.h"

namespace raygrid {
namespace {

// Returns the offset of the byte to lock in an empty file: bytes after the end
// of a file may be locked, too. Serials with the same byte merely wait for each
// other.
off_t GetLockByte(const std::string& serial) {
  ContentHash hash;
  hash.Add(serial);
  constexpr size_t kDigits = 12;
  return static_cast<off_t>(
      std::stoull(hash.Text().substr(0, kDigits), nullptr, 16));
}

}  // namespace

UnitLock::UnitLock(const std::string& folder, const std::string& serial) {
  const std::string path = folder + "/.batch.lock";
  constexpr mode_t kForAll = 0666;
  file_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kForAll);
  if (file_ < 0) ThrowWriteError(path, errno);
  struct flock lock = {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  lock.l_start = GetLockByte(serial);
  lock.l_len = 1;
  while (fcntl(file_, F_OFD_SETLKW, &lock) != 0 && errno == EINTR) {
  }
}

UnitLock::~UnitLock() { close(file_); }

}  // namespace raygrid
