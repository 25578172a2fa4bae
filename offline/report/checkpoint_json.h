#ifndef RAYGRID_REPORT_CHECKPOINT_JSON_H
#define RAYGRID_REPORT_CHECKPOINT_JSON_H

#include <string>

#include "evaluation/checkpoint.h"

namespace raygrid {

/// resume.json: a checkpoint, and what it is of, as a text that tells features
/// and options from others.
std::string FormatCheckpoint(const Checkpoint& checkpoint,
                             const std::string& inputs);

/// Throws InputError: no such file, malformed, or of other inputs.
Checkpoint ReadCheckpoint(const std::string& path, const std::string& inputs);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_CHECKPOINT_JSON_H
