#ifndef RAYGRID_REPORT_PICTURE_SECTIONS_H
#define RAYGRID_REPORT_PICTURE_SECTIONS_H

#include <string>

#include "evaluation/calibration_result.h"

namespace raygrid {

/// Coverage, residuals, bias, histograms and uncertainty of a camera.
std::string PicturesSection(const CalibrationResult& result);

/// How the lines of a camera that is not central pass the point that is nearest
/// to all; empty of a central one.
std::string LinesSection(const CalibrationResult& result);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_PICTURE_SECTIONS_H
