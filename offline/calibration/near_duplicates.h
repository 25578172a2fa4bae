#ifndef RAYGRID_CALIBRATION_NEAR_DUPLICATES_H
#define RAYGRID_CALIBRATION_NEAR_DUPLICATES_H

#include <optional>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "evaluation/calibration_result.h"

namespace raygrid {

/// Returns the default limit of feature motion between duplicates: 0.1 % of the
/// longer side of the image, but at least one pixel.
double DefaultDuplicatePx(const ImageSize& size);

/// Returns a larger limit, for images that differ too little to add
/// information: 0.5 % of the longer side, but at least two pixels.
double NearDuplicatePx(const ImageSize& size);

/// Groups images, or frames of a rig, that show the same view: an image is a
/// duplicate of another one that shows at least half of its features of each
/// board, 90 % of them less than duplicate_px away; for a rig, in all its
/// cameras. Groups are not chained: each image of a group is a duplicate of its
/// representative, the first of the images with the most features. Held-out
/// images have separate groups. Groups of one image are omitted; there are none
/// if duplicate_px is 0.
std::vector<NearDuplicates> FindNearDuplicates(
    const std::vector<Dataset>& cameras,
    const std::vector<std::string>& held_out,
    std::optional<double> duplicate_px);

/// Lists held-out images that duplicate a training image, sorted by name: their
/// held-out errors are hardly meaningful.
std::vector<std::string> FindHeldOutDuplicates(
    const std::vector<Dataset>& cameras,
    const std::vector<std::string>& held_out,
    std::optional<double> duplicate_px);

/// Returns the groups restricted to a dataset's images, if two or more.
std::vector<NearDuplicates> FilterGroups(
    const Dataset& dataset, const std::vector<NearDuplicates>& groups);

/// Returns the number of duplicates, without representatives, of all groups.
size_t CountDuplicates(const std::vector<NearDuplicates>& groups);

/// Returns the dataset without duplicates; representatives are kept.
Dataset RemoveDuplicates(const Dataset& dataset,
                         const std::vector<NearDuplicates>& groups);

/// Returns the duplicates, without representatives.
Dataset SelectDuplicates(const Dataset& dataset,
                         const std::vector<NearDuplicates>& groups);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_NEAR_DUPLICATES_H
