#ifndef RAYGRID_TOOLS_BATCH_SLURM_H
#define RAYGRID_TOOLS_BATCH_SLURM_H

#include <cstddef>
#include <string>

#include "commands.h"

namespace raygrid {

/// Submits a plan's units to Slurm as an array of at most 1,000 tasks, and a
/// job that gathers when all of them have ended. Tasks may be queued again at
/// any time. Says what was submitted. Throws Error(kUsage) where there is no
/// Slurm, and Error(kOutput) with Slurm's words if it refuses.
void SubmitToSlurm(const std::string& plan, const std::string& output,
                   size_t num_units, const CommonOptions& common);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_BATCH_SLURM_H
