#ifndef RAYGRID_DATASET_REPEATED_IMAGES_H
#define RAYGRID_DATASET_REPEATED_IMAGES_H

#include <optional>
#include <string>
#include <vector>

#include "dataset/dataset.h"

namespace raygrid {

/// For each image, the index of the first before it that shows the same
/// features, none more than 0.001 px from the other's, or nothing: a copy,
/// since no two photographs have the same noise. Nothing for images without
/// features.
std::vector<std::optional<size_t>> RepeatedImages(const Dataset& dataset);

/// An image of each of two datasets.
struct ImagePair {
  std::string first, second;
};

/// Two images that show the same features, none more than 0.001 px from the
/// other's, as a photograph that was given to two cameras; or else the first
/// two of one name, if most features of all images of one name lie less than
/// 0.05 px apart, as photographs that were saved again: two cameras that stand
/// apart do not see so. Nothing if there are none.
std::optional<ImagePair> FindSharedImage(const Dataset& first,
                                         const Dataset& second);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_REPEATED_IMAGES_H
