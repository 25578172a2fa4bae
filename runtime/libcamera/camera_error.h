#ifndef RAYGRID_LIBCAMERA_CAMERA_ERROR_H
#define RAYGRID_LIBCAMERA_CAMERA_ERROR_H

#include <stdexcept>
#include <string>

namespace raygrid {

enum class CameraExit {
  kDone = 0,
  kUsage = 1,
  kInput = 2,  // invalid file, or camera
  kOutput = 7,
  kBlob = 8  // corrupt, or for another stream
};

/// An error message of one line: what failed, where, and the remedy.
class CameraError : public std::runtime_error {
 public:
  CameraError(CameraExit code, const std::string& message)
      : std::runtime_error(message), code_(code) {}
  CameraExit code() const { return code_; }

 private:
  CameraExit code_;
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_CAMERA_ERROR_H
