#ifndef RAYGRID_REPORT_RESIDUAL_FILE_H
#define RAYGRID_REPORT_RESIDUAL_FILE_H

#include <map>
#include <string>
#include <vector>

#include "evaluation/rig_result.h"

namespace raygrid {

/// Rows of residuals.csv: more than a calibration of as many features as may be
/// given leaves.
constexpr size_t kMaxResidualRows = 2000000;

/// The residuals of one camera, or those that a rig leaves in it.
struct ResidualSets {
  std::vector<FeatureResidual> training, held_out, rejected;
  std::vector<FeatureResidual> held_out_in_rig;
};

/// residuals.csv: set,image,board,column,row,x,y,dx,dy in pixels, where
/// (dx, dy) = projected - observed; set is training, held-out, rejected or
/// held-out-in-rig. A rig's is led by a column that names the camera.
std::string FormatResiduals(const RigResult& result);

/// The residuals by camera name, "" where the file has no such column. Throws
/// InputError, also for more than kMaxResidualRows.
std::map<std::string, ResidualSets> ReadResiduals(const std::string& path);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_RESIDUAL_FILE_H
