#ifndef RAYGRID_REPORT_RIG_REPORT_H
#define RAYGRID_REPORT_RIG_REPORT_H

#include <optional>
#include <string>
#include <vector>

#include "evaluation/rig_result.h"
#include "report/stereo_pictures.h"

namespace raygrid {

/// report.html of a rig: its verdict, its cameras with their figures and in
/// space, a rectified pair if there is one, and links to their own reports,
/// NAME/report.html.
std::string FormatRigReport(
    const RigResult& result, const std::optional<StereoExample>& stereo = {},
    const std::vector<std::string>& rigid_target_summary = {});

}  // namespace raygrid

#endif  // RAYGRID_REPORT_RIG_REPORT_H
