#ifndef RAYGRID_REPORT_RESIDUAL_FILE_H
#define RAYGRID_REPORT_RESIDUAL_FILE_H

#include <map>
#include <string>
#include <vector>

#include "evaluation/rig_result.h"

namespace raygrid {

/// The maximum number of rows of residuals.csv, more than the maximum number of
/// features requires.
constexpr size_t kMaxResidualRows = 2000000;

/// The residuals of one camera, or of one camera within a rig.
struct ResidualSets {
  std::vector<FeatureResidual> training, held_out, rejected;
  std::vector<FeatureResidual> held_out_in_rig;
};

/// Formats residuals.csv with columns set,image,board,column,row,x,y,dx,dy, in
/// pixels, where (dx, dy) = projected - observed and set is training, held-out,
/// rejected or held-out-in-rig. For rigs, the first column is the camera's
/// name.
std::string FormatResiduals(const RigResult& result);

/// Reads residuals, keyed by camera name; "" if the file has no camera column.
/// Throws InputError if the file is malformed or has more than kMaxResidualRows
/// rows.
std::map<std::string, ResidualSets> ReadResiduals(const std::string& path);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_RESIDUAL_FILE_H
