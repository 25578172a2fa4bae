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

/// A camera image, and the same image undistorted by the runtime.
struct BeforeAfter {
  Image before, after;
};

/// Formats report.html: a self-contained file, for light and dark screens,
/// phones and print. The status comes first, then metrics and pictures, which
/// are visible without the script. Thumbnails are below their images'
/// residuals. With the camera's blob, readers can undistort photographs in the
/// page.
std::string FormatHtmlReport(
    const CalibrationResult& result,
    const std::optional<PackingMetrics>& packing,
    const std::optional<BeforeAfter>& example,
    const ThumbnailTexts& thumbnails = {}, const std::string& blob = {},
    const std::vector<std::string>& rigid_target_summary = {});

}  // namespace raygrid

#endif  // RAYGRID_REPORT_HTML_REPORT_H
