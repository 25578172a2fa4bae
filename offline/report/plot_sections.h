#ifndef RAYGRID_REPORT_PLOT_SECTIONS_H
#define RAYGRID_REPORT_PLOT_SECTIONS_H

#include <string>

#include "evaluation/calibration_result.h"

namespace raygrid {

/// Formats pictures of coverage, residuals, bias, histograms and uncertainty.
std::string MakePlotsSection(const CalibrationResult& result);

/// Formats the distances of a non-central camera's observation lines from the
/// point closest to all of them; empty for a central camera.
std::string MakeLinesSection(const CalibrationResult& result);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_PLOT_SECTIONS_H
