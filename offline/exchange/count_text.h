#ifndef RAYGRID_EXCHANGE_COUNT_TEXT_H
#define RAYGRID_EXCHANGE_COUNT_TEXT_H

#include <fmt/format.h>

#include <string>

namespace raygrid {

/// Formats "1 image", "2 images".
inline std::string CountText(size_t count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_COUNT_TEXT_H
