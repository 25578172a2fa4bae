#ifndef RAYGRID_CALIBRATION_NEAR_DUPLICATES_H
#define RAYGRID_CALIBRATION_NEAR_DUPLICATES_H

#include <optional>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "evaluation/calibration_result.h"

namespace raygrid {

/// How far features may move between images of one view, if nothing else is
/// asked for: 0.1 % of the longer side, but a pixel at least.
double DefaultDuplicatePx(const ImageSize& size);

/// How far features may move between images that are nearly one view: 0.5 % of
/// the longer side, but two pixels at least.
double NearDuplicatePx(const ImageSize& size);

/// The groups of images, or of a rig's instants, that show the same view: an
/// image tells nothing new beside another one that shows half of its features
/// of each board or more, nine in ten of them less than duplicate_px away. Of a
/// rig this holds in all its cameras. Groups do not chain: all images of one
/// are like the one that stands for it, which is the one with most features, or
/// the first of these. Images held out have groups of their own. Groups of one
/// image are left out; none is the same where duplicate_px is 0.
std::vector<NearDuplicates> FindNearDuplicates(
    const std::vector<Dataset>& cameras,
    const std::vector<std::string>& held_out,
    std::optional<double> duplicate_px);

/// The images held out that show a view of one that is not, in the order of
/// their names: what a camera predicts of them means little.
std::vector<std::string> FindHeldOutDuplicates(
    const std::vector<Dataset>& cameras,
    const std::vector<std::string>& held_out,
    std::optional<double> duplicate_px);

/// The groups that several of a dataset's images are in, with these alone.
std::vector<NearDuplicates> FilterGroups(
    const Dataset& dataset, const std::vector<NearDuplicates>& groups);

/// The images that others stand for, in all groups.
size_t CountDuplicates(const std::vector<NearDuplicates>& groups);

/// The images that stand for others, and those that are like no other.
Dataset RemoveDuplicates(const Dataset& dataset,
                         const std::vector<NearDuplicates>& groups);

/// The images that others stand for.
Dataset SelectDuplicates(const Dataset& dataset,
                         const std::vector<NearDuplicates>& groups);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_NEAR_DUPLICATES_H
