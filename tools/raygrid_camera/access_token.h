#ifndef RAYGRID_CAMERA_ACCESS_TOKEN_H
#define RAYGRID_CAMERA_ACCESS_TOKEN_H

#include <string>

namespace raygrid {

/// The word that a page's clients must know.
class AccessToken {
 public:
  /// 128 bits that nobody can guess, of the kernel.
  static AccessToken MakeRandom();
  /// The word in a file: 16 to 128 letters, digits, - or _, and a line's end.
  /// Throws CameraError (wrong usage).
  static AccessToken Read(const std::string& path);

  const std::string& text() const { return text_; }
  /// Takes the same time wherever a guess goes wrong.
  bool Is(const std::string& guess) const;

 private:
  explicit AccessToken(std::string text) : text_(std::move(text)) {}

  std::string text_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_ACCESS_TOKEN_H
