#ifndef RAYGRID_REPORT_HTML_REPORT_H
#define RAYGRID_REPORT_HTML_REPORT_H

#include <optional>
#include <string>
#include <vector>

#include "dataset/image_files.h"
#include "evaluation/calibration_result.h"
#include "report/page_data.h"
#include "report/result_json.h"

namespace raygrid {

/// An image as the camera took it, and undistorted by the runtime.
struct BeforeAfter {
  Image before, after;
};

/// report.html: one file without references to others, for light and dark
/// screens, phones and paper. Verdict first, then figures and pictures, which
/// also show without the script. Thumbnails stand under the residuals of their
/// images. With the camera's blob, readers undistort photographs in the page.
std::string FormatHtmlReport(
    const CalibrationResult& result,
    const std::optional<PackingFigures>& packing,
    const std::optional<BeforeAfter>& example,
    const ThumbnailTexts& thumbnails = {}, const std::string& blob = {},
    const std::vector<std::string>& rigid_target_summary = {});

}  // namespace raygrid

#endif  // RAYGRID_REPORT_HTML_REPORT_H
