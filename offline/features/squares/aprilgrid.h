#ifndef RAYGRID_FEATURES_SQUARES_APRILGRID_H
#define RAYGRID_FEATURES_SQUARES_APRILGRID_H

#include <memory>
#include <vector>

#include "features/board_view/detection.h"
#include "features/board_view/tag_detection.h"

namespace raygrid {

/// All tags of some families, whatever board they are on; found also where
/// black squares touch their corners. kQuick leaves out tags that are small or
/// blurred.
std::vector<DetectedTag> FindGridTags(const GreyImage& image,
                                      const std::vector<TagFamily>& families,
                                      TagSearch search = TagSearch::kThorough);

/// The family of an AprilGrid's AprilTags by its name.
TagFamily GridFamily(const std::string& tag_family, int border_cells);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_APRILGRID_H
