#ifndef RAYGRID_REPORT_PAGE_DATA_H
#define RAYGRID_REPORT_PAGE_DATA_H

#include <string>

#include "evaluation/calibration_result.h"
#include "evaluation/rig_result.h"

namespace raygrid {

/// What the page's script draws, as JSON: residuals of every image, their
/// distribution, the grid's control points, lines, and where the boards stood.
std::string PageData(const CalibrationResult& result);
/// Cameras and boards in space.
std::string PageData(const RigResult& result);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_PAGE_DATA_H
