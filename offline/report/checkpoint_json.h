#ifndef RAYGRID_REPORT_CHECKPOINT_JSON_H
#define RAYGRID_REPORT_CHECKPOINT_JSON_H

#include <string>
#include <vector>

#include "evaluation/checkpoint.h"

namespace raygrid {

/// Formats resume.json: the checkpoints of one camera, or of a rig's cameras,
/// and inputs, a text that identifies features and options.
std::string FormatCheckpoints(const std::vector<Checkpoint>& checkpoints,
                              const std::string& inputs);

/// Throws InputError if the file is missing, malformed, or was written for
/// other inputs.
std::vector<Checkpoint> ReadCheckpoints(const std::string& path,
                                        const std::string& inputs);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_CHECKPOINT_JSON_H
