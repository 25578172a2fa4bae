#ifndef RAYGRID_DATASET_HELD_STACK_H
#define RAYGRID_DATASET_HELD_STACK_H

#include <optional>

#include "dataset/camera_file.h"

namespace raygrid {

/// The stack over the conditions that are not held. Deviations are linear
/// between the values at which they are known.
StackOfCameras HoldStack(const StackOfCameras& stack, const HeldConditions& at);
/// The stack over one of the ranges, with the others in the middle.
StackOfCameras StackAlong(const StackOfCameras& stack, size_t range);

/// The file of a stack's camera where conditions are held at values in their
/// ranges, which are recorded as those at which the camera stood. It is a stack
/// over what is not held, if there is such a condition.
/// Cells are trusted that are trusted in the middle, and whose deviations at
/// the values are small enough, too.
CameraFile FileAt(const CameraFile& stack, const HeldConditions& at);

/// How well all cameras of a stack are known: in each place, the largest
/// deviation over the ranges, and cells that are trusted at all values.
std::optional<CameraUncertainty> UncertaintyOverRanges(const CameraFile& stack);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_HELD_STACK_H
