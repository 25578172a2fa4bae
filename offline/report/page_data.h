#ifndef RAYGRID_REPORT_PAGE_DATA_H
#define RAYGRID_REPORT_PAGE_DATA_H

#include <map>
#include <string>

#include "evaluation/calibration_result.h"
#include "evaluation/rig_result.h"

namespace raygrid {

/// Base64-encoded JPEG thumbnails, by image name.
using ThumbnailTexts = std::map<std::string, std::string>;

/// Formats the JSON for the page's script: residuals of every image, their
/// distribution, the grid's control points, observation lines, and board poses.
std::string FormatPageData(const CalibrationResult& result,
                           const ThumbnailTexts& thumbnails = {});
/// Formats the JSON of a rig's camera and board poses.
std::string FormatPageData(const RigResult& result);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_PAGE_DATA_H
