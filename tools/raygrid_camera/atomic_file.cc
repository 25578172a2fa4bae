#include "atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>

#include "camera_error.h"

namespace raygrid {

void MakeFolder(const std::string& folder) {
  struct stat status;
  if (mkdir(folder.c_str(), 0777) == 0) return;
  if (errno == EEXIST && stat(folder.c_str(), &status) == 0 &&
      S_ISDIR(status.st_mode))
    return;
  throw CameraError(CameraExit::kOutput,
                    folder + ": cannot create the folder (" +
                        std::strerror(errno) + "); use another path");
}

AtomicFile::AtomicFile(const char* path) {
  std::snprintf(path_, sizeof(path_), "%s", path);
  std::snprintf(part_, sizeof(part_), "%s.part", path_);
  fd_ = open(part_, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd_ < 0) Fail();
}

AtomicFile::~AtomicFile() {
  if (fd_ < 0) return;
  close(fd_);
  unlink(part_);
}

void AtomicFile::Write(const void* bytes, size_t size) {
  const char* next = static_cast<const char*>(bytes);
  while (size > 0) {
    const ssize_t written = write(fd_, next, size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) Fail();
    next += written;
    size -= static_cast<size_t>(written);
  }
}

void AtomicFile::Commit() {
  const int fd = fd_;
  fd_ = -1;
  if (close(fd) == 0 && rename(part_, path_) == 0) return;
  const int error = errno;
  unlink(part_);
  errno = error;
  Fail();
}

void AtomicFile::Fail() const {
  throw CameraError(CameraExit::kOutput,
                    std::string(path_) + ": cannot be written (" +
                        std::strerror(errno) +
                        "); free disk space, or use another path");
}

std::vector<uint8_t> ReadFileBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<uint8_t> bytes;
  if (file)
    bytes.assign(std::istreambuf_iterator<char>(file),
                 std::istreambuf_iterator<char>());
  if (!file || file.bad())
    throw CameraError(CameraExit::kInput,
                      path + ": cannot be read; check name and permissions");
  return bytes;
}

}  // namespace raygrid
