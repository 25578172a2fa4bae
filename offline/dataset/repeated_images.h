#ifndef RAYGRID_DATASET_REPEATED_IMAGES_H
#define RAYGRID_DATASET_REPEATED_IMAGES_H

#include <optional>
#include <vector>

#include "dataset/dataset.h"

namespace raygrid {

/// For each image, the index of the first before it that shows the same
/// features, none more than 0.001 px from the other's, or nothing: a copy,
/// since no two photographs have the same noise. Nothing for images without
/// features.
std::vector<std::optional<size_t>> RepeatedImages(const Dataset& dataset);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_REPEATED_IMAGES_H
