#ifndef RAYGRID_EXPERIMENTS_EXPERIMENT_FILES_H
#define RAYGRID_EXPERIMENTS_EXPERIMENT_FILES_H

#include <string>

#include "experiments/experiment.h"

namespace raygrid {

/// Formats the conditions, and the table in aligned columns.
std::string FormatExperimentText(const ExperimentResult& result);
/// Formats the conditions as comments, then the table.
std::string FormatExperimentCsv(const ExperimentResult& result);
/// {"experiment": name, "conditions": {...}, "rows": [{...}, ...]}.
std::string FormatExperimentJson(const std::string& name,
                                 const ExperimentResult& result);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_EXPERIMENT_FILES_H
