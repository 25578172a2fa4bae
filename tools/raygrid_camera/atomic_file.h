#ifndef RAYGRID_CAMERA_ATOMIC_FILE_H
#define RAYGRID_CAMERA_ATOMIC_FILE_H

#include <climits>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace raygrid {

/// Creates the folder if it does not exist. Throws CameraError.
void MakeFolder(const std::string& folder);

/// A file that is written completely or not at all: a temporary file is
/// renamed. No memory is allocated.
class AtomicFile {
 public:
  explicit AtomicFile(const char* path);
  ~AtomicFile();  // removes the file if it was not committed
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void Write(const void* bytes, size_t size);
  void Commit();

 private:
  [[noreturn]] void Fail() const;

  char path_[PATH_MAX], part_[PATH_MAX + 8];
  int fd_;
};

/// Reads a file. Throws CameraError.
std::vector<uint8_t> ReadFileBytes(const std::string& path);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_ATOMIC_FILE_H
