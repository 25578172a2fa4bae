#include "dataset/token_lines.h"

#include <fmt/format.h>

#include "dataset/error.h"
#include "dataset/text_encoding.h"

namespace raygrid {

bool TokenLines::Next() {
  std::string line;
  do {
    if (!std::getline(stream_, line)) return false;
    ++number_;
  } while (!line.empty() && line[0] == '#');
  std::istringstream words(line);
  words_.clear();
  for (std::string word; words >> word;) words_.push_back(word);
  return true;
}

bool TokenLines::NextNonEmpty() {
  while (Next())
    if (!words_.empty()) return true;
  return false;
}

const std::string& TokenLines::Text(size_t index) const {
  if (index >= words_.size()) ThrowError("too few fields");
  return words_[index];
}

void TokenLines::ThrowError(const std::string& why) const {
  throw InputError(fmt::format("{}, line {}: {}; expected {}", path_, number_,
                               why, expected_));
}

void TokenLines::ThrowInvalidNumber(const std::string& text) const {
  ThrowError("'" + Printable(text) + "' is not a number");
}

}  // namespace raygrid
