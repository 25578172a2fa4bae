#ifndef RAYGRID_REPORT_PAGE_DATA_H
#define RAYGRID_REPORT_PAGE_DATA_H

#include <map>
#include <string>

#include "evaluation/calibration_result.h"
#include "evaluation/rig_result.h"

namespace raygrid {

/// Small JPEG files as Base64, by the names of their images.
using ThumbnailTexts = std::map<std::string, std::string>;

/// The JSON that the page's script draws: residuals of every image, their
/// distribution, the grid's control points, lines, and where the boards stood.
std::string PageData(const CalibrationResult& result,
                     const ThumbnailTexts& thumbnails = {});
/// The JSON of the cameras and boards of a rig in space.
std::string PageData(const RigResult& result);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_PAGE_DATA_H
