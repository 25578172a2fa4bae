#ifndef RAYGRID_EVALUATION_CHECKPOINT_H
#define RAYGRID_EVALUATION_CHECKPOINT_H

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "camera/pose.h"
#include "dataset/dataset.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {

/// What an interrupted calibration of one camera need not do again.
struct Checkpoint {
  /// Features as measured through a first camera.
  std::optional<Dataset> measured_again;

  /// Parts of the cross-validation that are done.
  struct Trial {
    int fold = 0;
    double cell_px = 0;
    std::vector<FeatureResidual> held_out;
  };
  std::vector<Trial> trials;

  /// Where the last adjustment was.
  struct Adjustment {
    Eigen::VectorXd camera;  ///< parameters
    std::vector<Pose> poses;
    std::vector<Eigen::Vector3d> points;
    std::vector<double> prior_weights;  ///< of the groups
    double points_weight = 0;
  };
  std::optional<Adjustment> adjustment;
};

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_CHECKPOINT_H
