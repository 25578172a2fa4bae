#ifndef RAYGRID_REPORT_CHECKPOINT_JSON_H
#define RAYGRID_REPORT_CHECKPOINT_JSON_H

#include <string>
#include <vector>

#include "evaluation/checkpoint.h"

namespace raygrid {

/// resume.json: the checkpoints of one camera, or of a rig's, and what they are
/// of, as a text that tells features and options from others.
std::string FormatCheckpoints(const std::vector<Checkpoint>& checkpoints,
                              const std::string& inputs);

/// Throws InputError: no such file, malformed, altered, or of other inputs.
std::vector<Checkpoint> ReadCheckpoints(const std::string& path,
                                        const std::string& inputs);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_CHECKPOINT_JSON_H
