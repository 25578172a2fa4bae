/// Input of operating points (lens positions and temperatures) for calibration.
#ifndef RAYGRID_TOOLS_OPERATING_POINT_INPUT_H
#define RAYGRID_TOOLS_OPERATING_POINT_INPUT_H

#include <functional>
#include <optional>
#include <string>

#include "calibration/operating_point_calibration.h"
#include "calibration_input.h"

namespace raygrid {

struct SessionFrame;

/// Adds the options of raygrid calibrate for operating points.
void AddOperatingPointOptions(CLI::App* command, CalibrateArguments* arguments);

/// Throws Error(kUsage) for contradicting options.
void RequireOperatingPointOptions(const CalibrateArguments& arguments,
                                  bool is_rig);

/// Whether values are read from EXIF: images are given without another source
/// of operating points.
bool UsesExifValues(const CalibrateArguments& arguments);

/// Detects features in images with operating points from EXIF. Throws
/// InputError for the first image without a value, before any detection.
Measurements MeasureWithExif(const std::vector<std::string>& images,
                             const CalibrateArguments& arguments,
                             const CommonOptions& common,
                             const Pattern& pattern,
                             const std::function<void(double)>& progress);

/// Detects features in the folders of --images-at. Names of their images
/// include the value: VALUE/IMAGE. Throws Error(kUsage), InputError.
Measurements MeasureFoldersAt(const CalibrateArguments& arguments,
                              const CommonOptions& common,
                              const Pattern& pattern,
                              const std::function<void(double)>& progress);

/// Returns the requested variables of a session's frame; nullopt if one is
/// missing.
std::optional<OperatingPoint> GetOperatingPoint(
    const CalibrateArguments& arguments, const SessionFrame& frame);

/// Returns the operating points of all images; nullopt if no variable is
/// requested. Throws Error(kUsage), InputError.
std::optional<ImageOperatingPoints> ReadOperatingPoints(
    const CalibrateArguments& arguments, const Measurements& measurements);

/// Returns a warning about rows of --operating-points that match no image;
/// empty if there are none.
std::string WarnAboutUnmatchedRows(const CalibrateArguments& arguments,
                                   const ImageOperatingPoints& conditions,
                                   const Measurements& measurements);

/// Returns a warning about values that are implausible in dioptres or °C; empty
/// if there are none.
std::string WarnAboutUnits(const ImageOperatingPoints& conditions);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_OPERATING_POINT_INPUT_H
