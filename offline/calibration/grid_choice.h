#ifndef RAYGRID_CALIBRATION_GRID_CHOICE_H
#define RAYGRID_CALIBRATION_GRID_CHOICE_H

#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "evaluation/calibration_result.h"

namespace raygrid {

/// Cells as parts of the longer side: coarse enough for a handful of images,
/// and as fine as is quick.
std::vector<double> CellCandidates(const Dataset& dataset,
                                   const std::string& model);

/// The loss of cells by the held-out residuals over all folds.
CellCandidate Summarize(double cell_px,
                        const std::vector<FeatureResidual>& held_out);

/// The coarsest that is as good as the best, nearly.
size_t ChooseCandidate(const std::vector<CellCandidate>& candidates);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_GRID_CHOICE_H
