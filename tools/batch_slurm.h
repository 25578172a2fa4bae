#ifndef RAYGRID_TOOLS_BATCH_SLURM_H
#define RAYGRID_TOOLS_BATCH_SLURM_H

#include <cstddef>
#include <string>

#include "commands.h"

namespace raygrid {

/// Submits a plan's units to Slurm as an array of at most 1,000 tasks, and a
/// job that gathers the results after all tasks. Tasks may be requeued at any
/// time. Prints what was submitted. Throws Error(kUsage) if Slurm is not
/// installed, and Error(kOutputFailed) with Slurm's message if it rejects the
/// jobs.
void SubmitToSlurm(const std::string& plan, const std::string& output,
                   size_t num_units, const CommonOptions& common);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_BATCH_SLURM_H
