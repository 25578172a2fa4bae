#ifndef RAYGRID_CAMERA_ACCESS_TOKEN_H
#define RAYGRID_CAMERA_ACCESS_TOKEN_H

#include <string>

namespace raygrid {

/// The secret that clients of a page must present.
class AccessToken {
 public:
  /// Returns 128 random bits from the kernel.
  static AccessToken MakeRandom();
  /// Reads the token from a file: 16 to 128 letters, digits, - or _, and a
  /// newline. Throws CameraError (wrong usage).
  static AccessToken Read(const std::string& path);

  const std::string& text() const { return text_; }
  /// Compares in constant time.
  bool Is(const std::string& guess) const;

 private:
  explicit AccessToken(std::string text) : text_(std::move(text)) {}

  std::string text_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_ACCESS_TOKEN_H
