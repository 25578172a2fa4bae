/// The causes of a calibration's residuals, told apart by prediction: a cause
/// fitted to one half of the features explains what it predicts of the other.
#ifndef RAYGRID_EVALUATION_RESIDUAL_BUDGET_H
#define RAYGRID_EVALUATION_RESIDUAL_BUDGET_H

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "camera/area.h"
#include "camera/model_names.h"

namespace raygrid {

/// A residual, and how it depends on what may be its cause.
struct BudgetFeature {
  int view = 0;   ///< of one board in one image; they count on
  int point = 0;  ///< of all boards' points
  int column = 0, row = 0;
  Eigen::Vector2d pixel, error_px;
  Eigen::Matrix<double, 2, 3> by_point;  ///< in the board's frame
  /// By a rotation and a translation in the camera's frame.
  Eigen::Matrix<double, 2, 6> by_pose;
};

/// Steps that a calibration has done: they are not to be advised again.
struct BudgetFacts {
  std::string model;
  double cell_px = 0;         ///< of a grid
  bool cells_chosen = false;  ///< by held-out error, of several
  bool tried_finer = false;   ///< a finer grid predicted no better
  bool points_free = false;   ///< the board's points were estimated
  bool bends_tried = false;   ///< bends of each view were tried, or adjusted
  /// Other models that were tried beside this one.
  bool generic_tried = false, noncentral_tried = false;
  std::string better_model;  ///< of them, if it predicts held-out images better
  bool two_cameras = false;  ///< the images look like those of two

  bool IsGrid() const {
    return model == models::kCentralGeneric ||
           model == models::kNonCentralGeneric;
  }
};

struct BudgetInput {
  ImageSize image_size;
  std::vector<BudgetFeature> features;  ///< those of a view in a row
  std::vector<Eigen::Vector3d> points;  ///< of all boards, in their frames
  std::vector<int> boards;              ///< of each point
  /// The ways in which boards bend, 3 x k for each point; or none.
  std::vector<Eigen::Matrix3Xd> bends;
  int num_parameters = 0;  ///< that were fitted to these residuals
  BudgetFacts facts;
};

enum class ErrorCause {
  kImagePlace,   ///< shared by features in one place of the image
  kBoardPlace,   ///< shared by features of one point of the board
  kBend,         ///< the board bends out of its plane, by view
  kInPlane,      ///< the board is stretched or sheared in its plane, by view
  kImageAffine,  ///< the image is scaled or shifted, by view
  kRowTime,      ///< rows are taken while the camera moves, by view
};
constexpr int kNumErrorCauses = 6;

/// "lens model", ...
const char* NameOf(ErrorCause cause);

/// The share of one cause. Parts are of the sum of all squared residuals.
struct CauseShare {
  bool can_be_told = false;
  std::string untold;  ///< why not
  double alone = 0;    ///< before other causes are taken away; may be negative
  double in_turn = 0;  ///< of what the causes before it leave; these add up
  double chance_mean = 0, chance_high = 0;  ///< `alone`, of errors by chance
  /// Of views' causes: it explains the views as well as the largest of these
  /// does, as far as the differences between views tell.
  bool is_alike = false;
  bool IsTold() const { return can_be_told && in_turn > 0; }
};

struct ResidualBudget {
  std::string untold;  ///< why nothing can be told; else empty
  int num_features = 0, num_views = 0;
  double rms_px = 0;  ///< in an axis
  /// The standard deviation of noise in x and y: what each feature has of its
  /// own.
  Eigen::Vector2d noise_px = Eigen::Vector2d::Zero();
  double noise = 0;  ///< part of the squared residuals
  double large = 0;  ///< what single errors have beyond five deviations
  std::array<CauseShare, kNumErrorCauses> causes;
  /// Motion from column to column explains this alone. No camera has it, so a
  /// cause that views have must explain more.
  double column_time = 0;
  bool column_time_is_alike = false;
  double rest = 0;  ///< what nothing explains; may be negative
  BudgetFacts facts;

  const CauseShare& Of(ErrorCause cause) const {
    return causes[static_cast<size_t>(cause)];
  }
  /// All causes that views have of their own, together.
  double OfViews() const;
};

/// Results are the same on any machine.
ResidualBudget MeasureResidualBudget(const BudgetInput& input);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_RESIDUAL_BUDGET_H
