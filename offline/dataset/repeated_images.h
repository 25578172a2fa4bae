#ifndef RAYGRID_DATASET_REPEATED_IMAGES_H
#define RAYGRID_DATASET_REPEATED_IMAGES_H

#include <optional>
#include <string>
#include <vector>

#include "dataset/dataset.h"

namespace raygrid {

/// Returns, for each image, the index of the first previous image with the same
/// features within 0.001 px. Such images are copies, since noise differs
/// between photographs. nullopt if there is none, and for images without
/// features.
std::vector<std::optional<size_t>> RepeatedImages(const Dataset& dataset);

/// One image from each of two datasets.
struct ImagePair {
  std::string first, second;
};

/// Finds two images with the same features within 0.001 px, as if a photograph
/// was assigned to two cameras; otherwise the first two images of equal name,
/// if most features of all images of equal names differ by less than 0.05 px,
/// as in re-encoded photographs, which is impossible for separate cameras.
/// nullopt if there are none.
std::optional<ImagePair> FindSharedImage(const Dataset& first,
                                         const Dataset& second);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_REPEATED_IMAGES_H
