#include "side_by_side.h"

#include <algorithm>

namespace raygrid {

GreyBuffer ConcatenateHorizontally(
    const std::vector<const GreyImage*>& pictures) {
  GreyBuffer all;
  for (const GreyImage* picture : pictures) {
    all.width += picture->size.width;
    all.height = std::max(all.height, picture->size.height);
  }
  all.bytes.assign(static_cast<size_t>(all.width) * all.height, 0);
  auto column = all.bytes.begin();
  for (const GreyImage* picture : pictures) {
    const int width = picture->size.width;
    for (int row = 0; row < picture->size.height; ++row)
      std::copy_n(picture->bytes.begin() + std::ptrdiff_t{row} * width, width,
                  column + std::ptrdiff_t{row} * all.width);
    column += width;
  }
  return all;
}

}  // namespace raygrid
