#include "image_size_option.h"

#include <fmt/format.h>

#include <charconv>
#include <cstdint>

#include "dataset/error.h"
#include "dataset/image_header.h"

namespace raygrid {

ImageSize ParseImageSize(const std::string& option, const std::string& text) {
  uint64_t width = 0, height = 0;
  const char* const end = text.data() + text.size();
  const auto at_x = std::from_chars(text.data(), end, width);
  auto at_end = at_x;
  if (at_x.ec == std::errc() && at_x.ptr != end && *at_x.ptr == 'x')
    at_end = std::from_chars(at_x.ptr + 1, end, height);
  if (at_end.ec != std::errc() || at_end.ptr != end || width < 1 || height < 1)
    throw Error(ExitCode::kUsage,
                fmt::format("{} {}: expected WIDTHxHEIGHT, such as 640x480",
                            option, text));
  const std::string why = DescribeSizeLimit(width, height);
  if (!why.empty())
    throw Error(ExitCode::kUsage, fmt::format("{}: {}", option, why));
  return {static_cast<int>(width), static_cast<int>(height)};
}

}  // namespace raygrid
