#include "access_token.h"

#include <sys/random.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <vector>

#include "atomic_file.h"
#include "camera_error.h"

namespace raygrid {

AccessToken AccessToken::MakeRandom() {
  uint8_t bytes[16];
  if (getrandom(bytes, sizeof(bytes), 0) != sizeof(bytes))
    throw CameraError(CameraExit::kInput,
                      "--listen: cannot get random numbers from the kernel; "
                      "set a token with --token-file");
  std::string text;
  for (const uint8_t byte : bytes)
    for (const int digit : {byte >> 4, byte & 15})
      text += "0123456789abcdef"[digit];
  return AccessToken(text);
}

AccessToken AccessToken::Read(const std::string& path) {
  const std::vector<uint8_t> bytes = ReadFileBytes(path);
  std::string text(bytes.begin(), bytes.end());
  if (!text.empty() && text.back() == '\n') text.pop_back();
  const bool has_only_letters =
      std::all_of(text.begin(), text.end(), [](unsigned char letter) {
        return letter < 128 &&
               (std::isalnum(letter) || letter == '-' || letter == '_');
      });
  if (text.size() < 16 || text.size() > 128 || !has_only_letters)
    throw CameraError(CameraExit::kUsage,
                      "--token-file: " + path +
                          ": expected one line of 16 to 128 letters, digits, - "
                          "and _; create one with openssl rand -hex 16");
  return AccessToken(text);
}

bool AccessToken::Is(const std::string& guess) const {
  if (guess.size() != text_.size()) return false;
  unsigned char difference = 0;
  for (size_t i = 0; i < text_.size(); ++i)
    difference |= static_cast<unsigned char>(guess[i] ^ text_[i]);
  return difference == 0;
}

}  // namespace raygrid
