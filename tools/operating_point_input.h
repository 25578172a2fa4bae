/// The lens positions and temperatures that a calibration goes over.
#ifndef RAYGRID_TOOLS_OPERATING_POINT_INPUT_H
#define RAYGRID_TOOLS_OPERATING_POINT_INPUT_H

#include <functional>
#include <optional>
#include <string>

#include "calibration/operating_point_calibration.h"
#include "calibration_input.h"

namespace raygrid {

struct SessionFrame;

/// The options of raygrid calibrate for them.
void AddOperatingPointOptions(CLI::App* command, CalibrateArguments* arguments);

/// Throws Error(kUsage) for options that do not go together.
void RequireOperatingPointOptions(const CalibrateArguments& arguments,
                                  bool is_rig);

/// Whether the values are those of EXIF: images are given, and nothing else
/// says them.
bool UsesExifValues(const CalibrateArguments& arguments);

/// Measures images whose EXIF data tell the conditions. Throws InputError that
/// names the first one without a value, before it measures any.
Measurements MeasureWithExif(const std::vector<std::string>& images,
                             const CalibrateArguments& arguments,
                             const CommonOptions& common,
                             const Pattern& pattern,
                             const std::function<void(double)>& progress);

/// Measures the folders of --images-at. Their images are named after the value,
/// too: VALUE/IMAGE. Throws Error(kUsage), InputError.
Measurements MeasureFoldersAt(const CalibrateArguments& arguments,
                              const CommonOptions& common,
                              const Pattern& pattern,
                              const std::function<void(double)>& progress);

/// The values of the conditions that are asked for, as a session's frame has
/// them; nothing if it lacks one.
std::optional<OperatingPoint> GetOperatingPoint(
    const CalibrateArguments& arguments, const SessionFrame& frame);

/// The values in each image; nothing if no condition is asked for. Throws
/// Error(kUsage), InputError.
std::optional<ImageOperatingPoints> ReadOperatingPoints(
    const CalibrateArguments& arguments, const Measurements& measurements);

/// A remark on rows of --operating-points that name none of the images; empty
/// if all rows do.
std::string WarnAboutUnmatchedRows(const CalibrateArguments& arguments,
                                   const ImageOperatingPoints& conditions,
                                   const Measurements& measurements);

/// A remark on values that are not in dioptres or °C, by their size; empty if
/// all may be.
std::string WarnAboutUnits(const ImageOperatingPoints& conditions);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_OPERATING_POINT_INPUT_H
