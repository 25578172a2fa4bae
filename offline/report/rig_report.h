#ifndef RAYGRID_REPORT_RIG_REPORT_H
#define RAYGRID_REPORT_RIG_REPORT_H

#include <string>

#include "evaluation/rig_result.h"

namespace raygrid {

/// report.html of a rig: its verdict, its cameras with their figures and in
/// space, and links to their own reports, NAME/report.html.
std::string FormatRigReport(const RigResult& result);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_RIG_REPORT_H
