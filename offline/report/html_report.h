#ifndef RAYGRID_REPORT_HTML_REPORT_H
#define RAYGRID_REPORT_HTML_REPORT_H

#include <optional>
#include <string>

#include "dataset/image_files.h"
#include "evaluation/calibration_result.h"
#include "evaluation/rig_result.h"

namespace raygrid {

/// An image as the camera took it, and undistorted by the runtime.
struct BeforeAfter {
  std::string name;
  Image before, after;
};

/// What packing found.
struct PackingFigures {
  size_t blob_bytes = 0;
  double unproject_error_px = 0;
  std::optional<double> remap_error_px;
};

/// report.html: one file without references to others, for light and dark
/// screens and for paper. Verdict first, then numbers and pictures.
std::string FormatHtmlReport(const CalibrationResult& result,
                             const std::optional<PackingFigures>& packing,
                             const std::optional<BeforeAfter>& example);

/// A rig's: its verdict, its cameras with their figures, and links to their
/// own reports, NAME/report.html.
std::string FormatRigReport(const RigResult& result);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_HTML_REPORT_H
