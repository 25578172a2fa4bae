#ifndef RAYGRID_DATASET_TOKEN_LINES_H
#define RAYGRID_DATASET_TOKEN_LINES_H

#include <charconv>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

namespace raygrid {

/// Reads tokens separated by white space, line by line, skipping lines that
/// begin with '#'.
class TokenLines {
 public:
  /// Errors name the path and the expected format, such as "a text model as
  /// COLMAP writes it".
  TokenLines(const std::string& path, const std::string& text,
             const std::string& expected)
      : path_(path), expected_(expected), stream_(text) {}

  /// Advances to the next line, which may be empty; returns false at the end.
  bool Next();
  bool NextNonEmpty();

  size_t size() const { return words_.size(); }
  /// Throws InputError if the line has too few tokens.
  const std::string& Text(size_t index) const;
  /// Returns a finite number. Throws InputError.
  template <typename Number>
  Number Get(size_t index) const {
    const std::string& text = Text(index);
    Number number = 0;
    const char* end = text.data() + text.size();
    const auto result = std::from_chars(text.data(), end, number);
    if (result.ec != std::errc() || result.ptr != end ||
        !std::isfinite(static_cast<double>(number)))
      ThrowInvalidNumber(text);
    return number;
  }
  /// Throws InputError, with the path and the line.
  [[noreturn]] void ThrowError(const std::string& why) const;

 private:
  [[noreturn]] void ThrowInvalidNumber(const std::string& text) const;

  std::string path_, expected_;
  std::istringstream stream_;
  std::vector<std::string> words_;
  int number_ = 0;
};

}  // namespace raygrid

#endif  // RAYGRID_DATASET_TOKEN_LINES_H
