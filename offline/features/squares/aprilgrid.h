#ifndef RAYGRID_FEATURES_SQUARES_APRILGRID_H
#define RAYGRID_FEATURES_SQUARES_APRILGRID_H

#include <memory>
#include <vector>

#include "features/board_view/detection.h"
#include "features/board_view/tag_detection.h"

namespace raygrid {

/// Detects all tags of the given families, on any board, even if black squares
/// touch their corners. kQuick may miss small or blurred tags.
std::vector<DetectedTag> FindGridTags(const GreyImage& image,
                                      const std::vector<TagFamily>& families,
                                      TagSearch search = TagSearch::kThorough);

/// Returns the AprilTag family (including border width) by its name.
TagFamily GridFamily(const std::string& tag_family, int border_cells);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_APRILGRID_H
