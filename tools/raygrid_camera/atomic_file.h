#ifndef RAYGRID_CAMERA_ATOMIC_FILE_H
#define RAYGRID_CAMERA_ATOMIC_FILE_H

#include <climits>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace raygrid {

/// Makes the folder, if there is none. Throws CameraError.
void MakeFolder(const std::string& folder);

/// A file that appears whole or not at all: written beside, then renamed. No
/// memory is allocated.
class AtomicFile {
 public:
  explicit AtomicFile(const char* path);
  ~AtomicFile();  // removes what was not committed
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void Write(const void* bytes, size_t size);
  void Commit();

 private:
  [[noreturn]] void Fail() const;

  char path_[PATH_MAX], part_[PATH_MAX + 8];
  int fd_;
};

/// Throws CameraError.
std::vector<uint8_t> ReadWholeFile(const std::string& path);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_ATOMIC_FILE_H
