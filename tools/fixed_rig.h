/// Cameras with fixed intrinsics, and the features to localize targets with.
#ifndef RAYGRID_TOOLS_FIXED_RIG_H
#define RAYGRID_TOOLS_FIXED_RIG_H

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calibration/rig_evaluation.h"
#include "camera_input.h"

namespace raygrid {

/// A camera or the cameras of a rig.
struct FixedRig {
  bool is_rig = false;
  std::vector<std::string> names;  ///< {""} for a single camera
  std::vector<CameraInput> cameras;
  RigModel model;  ///< refers to the cameras
};

/// Reads a camera as ReadCamera(), or rig.yaml with its cameras. Throws
/// Error(kUsage) for the operating point of a rig.
FixedRig ReadFixedRig(const std::string& path,
                      const RequestedOperatingPoint& at);

/// Returns the rig in the first camera's frame, with the targets of the
/// pattern.
RigModel LocalizingRig(const FixedRig& rig, const Pattern& pattern);

/// Reads features.csv by camera; empty datasets for cameras without features.
/// Applies UseRuntimeRays() to the features of blobs. Throws InputError if the
/// file has another camera, or as RequireConsistent().
std::vector<Dataset> ReadRigFeatures(const FixedRig& rig,
                                     const std::string& path,
                                     const Pattern& pattern);

/// If a camera is a blob, replaces each pixel by that to which the model
/// assigns the ray of the runtime, which is in fixed point.
void UseRuntimeRays(const CameraInput& camera, Dataset* dataset);

/// Throws Error(kInsufficientData) if nothing was localized.
void RequireLocalized(size_t count);

/// Formats metrics as a phrase.
std::string FormatErrorMetrics(const ErrorMetrics& metrics);

nlohmann::ordered_json RejectedImagesJson(
    const std::vector<RejectedImage>& images);
void PrintRejectedImages(const std::vector<RejectedImage>& images);

/// Formats the IDs of the boards of each rigid target; as a phrase, "" without
/// any.
nlohmann::ordered_json MakeRigidTargetsJson(const Pattern& pattern);
std::string FormatRigidTargets(const Pattern& pattern);

/// Prints how boards are localized, if there are several.
void PrintHowLocalized(const Pattern& pattern);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_FIXED_RIG_H
