#ifndef RAYGRID_CALIBRATION_ADJUSTMENT_RESULT_H
#define RAYGRID_CALIBRATION_ADJUSTMENT_RESULT_H

#include <vector>

#include "adjustment/bundle_adjustment.h"
#include "calibration/calibration_problem.h"

namespace raygrid {

/// Result of a bundle adjustment, without metrics.
struct AdjustmentResult {
  CalibrationProblem problem;
  AdjustmentState state;
  AdjustmentSummary summary;
  GaussianPrior prior;  ///< with the estimated precisions
  /// Base models of the grids, one per camera; empty unless they were fitted to
  /// the features.
  std::vector<BaseModel> base_models;
  std::vector<RejectedImage> rejected_images;
  std::vector<std::vector<FeatureResidual>> rejected_features;  ///< one list
                                                                ///< per camera
};

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_ADJUSTMENT_RESULT_H
