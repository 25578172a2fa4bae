#ifndef RAYGRID_REPORT_RIG_REPORT_H
#define RAYGRID_REPORT_RIG_REPORT_H

#include <optional>
#include <string>
#include <vector>

#include "evaluation/rig_result.h"
#include "report/stereo_figures.h"

namespace raygrid {

/// Formats report.html of a rig: its status, its cameras with metrics and in
/// 3D, a rectified pair if available, and links to the cameras' reports,
/// NAME/report.html.
std::string FormatRigReport(
    const RigResult& result, const std::optional<StereoExample>& stereo = {},
    const std::vector<std::string>& rigid_target_summary = {});

}  // namespace raygrid

#endif  // RAYGRID_REPORT_RIG_REPORT_H
