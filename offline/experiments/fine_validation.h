#ifndef RAYGRID_EXPERIMENTS_FINE_VALIDATION_H
#define RAYGRID_EXPERIMENTS_FINE_VALIDATION_H

#include "experiments/experiment.h"

namespace raygrid {

/// Validates models in the paper's regime: lenses with bumps 20 to 60 px wide,
/// hundreds of star boards, and knot spacings of 30, 20 and 10 px.
ExperimentResult ValidateFineModels(const ExperimentOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_FINE_VALIDATION_H
