#include "key_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "dataset/error.h"

namespace raygrid {

std::vector<std::string> SplitAtKeys(const std::string& text) {
  std::vector<std::string> parts;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    if (!parts.empty() && part.find('=') == std::string::npos)
      parts.back() += ',' + part;
    else
      parts.push_back(part);
    begin = end + 1;
  }
  return parts;
}

std::vector<double> ParseNumbers(const std::string& place,
                                 const std::string& text, size_t count,
                                 const char* example) {
  std::vector<double> numbers;
  const char *at = text.data(), *const end = text.data() + text.size();
  while (numbers.size() < count) {
    double value = NAN;
    const auto [next, fault] = std::from_chars(at, end, value);
    if (fault != std::errc() || !std::isfinite(value)) break;
    numbers.push_back(value);
    at = next;
    if (at == end || *at != ',') break;
    ++at;
  }
  if (numbers.size() == count && at == end && text.back() != ',')
    return numbers;
  static const char* const kCounts[] = {"no numbers", "a number", "two numbers",
                                        "three numbers", "four numbers"};
  throw Error(ExitCode::kUsage,
              fmt::format("{}: expected {}, such as {}, not '{}'", place,
                          kCounts[count], example, text));
}

}  // namespace raygrid
