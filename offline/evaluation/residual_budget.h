/// Attributes the residuals of a calibration to causes by prediction: a cause
/// is fitted to one half of the features, and its share is the reduction of the
/// squared residuals of the other half.
#ifndef RAYGRID_EVALUATION_RESIDUAL_BUDGET_H
#define RAYGRID_EVALUATION_RESIDUAL_BUDGET_H

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "camera/area.h"
#include "camera/model_names.h"

namespace raygrid {

/// A residual, and its Jacobians with respect to possible causes.
struct BudgetFeature {
  int view = 0;   ///< index of a view: one board in one image
  int point = 0;  ///< index over all boards
  int column = 0, row = 0;
  Eigen::Vector2d pixel, error_px;
  Eigen::Matrix<double, 2, 3> J_point;  ///< Jacobian by the point in the
                                        ///< board's frame
  /// Jacobian by a rotation and a translation in the camera frame.
  Eigen::Matrix<double, 2, 6> J_pose;
};

/// Models and options that a calibration already uses or has tried, so that
/// they are not recommended.
struct BudgetSummary {
  std::string model;
  double knot_spacing_px = 0;  ///< knot spacing of a grid
  bool knot_spacing_selected =
      false;  ///< knot spacing was selected by held-out error
  bool has_tried_finer_grid = false;  ///< a finer grid did not predict better
  bool has_estimated_points = false;  ///< target points were estimated
  bool has_tried_deformation =
      false;  ///< per-view deformation was tried or estimated
  /// Models that were compared with this one.
  bool has_tried_generic_model = false, has_tried_noncentral_model = false;
  std::string better_model;    ///< name of a model with lower held-out error
  bool mixed_cameras = false;  ///< the images seem to be from two cameras

  bool IsGrid() const {
    return model == models::kCentralGeneric ||
           model == models::kNonCentralGeneric;
  }
};

struct BudgetInput {
  ImageSize image_size;
  std::vector<BudgetFeature> features;  ///< contiguous by view
  std::vector<Eigen::Vector3d> points;  ///< points in board frames
  std::vector<int> boards;              ///< board by point
  /// Deformation modes, 3 x k for each point; may be empty.
  std::vector<Eigen::Matrix3Xd> bends;
  int num_parameters = 0;  ///< number fitted to these residuals
  BudgetSummary facts;
};

enum class ErrorCause {
  kImagePosition,   ///< shared by features in one region of the image
  kBoardPosition,   ///< shared by features of one target point
  kDeformation,     ///< out-of-plane deformation of the board, per view
  kInPlane,         ///< in-plane deformation of the board, per view
  kImageAffine,     ///< scale or shift of the image, per view
  kRollingShutter,  ///< rolling shutter with camera motion, per view
};
constexpr int kNumErrorCauses = 6;

/// Returns the name of a cause: "lens model", ...
const char* ToString(ErrorCause cause);

/// The fraction of the sum of squared residuals due to one cause.
struct CauseShare {
  bool is_observable = false;
  std::string unobservable_reason;  ///< why it is not observable
  double alone = 0;  ///< before removing other causes; may be negative
  double sequential_share =
      0;  ///< after removing previous causes; these add up
  double random_mean = 0, random_limit = 0;  ///< `alone` for random errors
  /// For per-view causes: whether this cause explains the views as well as the
  /// largest cause, i.e. the difference is insignificant.
  bool is_indistinguishable = false;
  bool IsDetermined() const { return is_observable && sequential_share > 0; }
};

struct ResidualBudget {
  std::string unobservable_reason;  ///< why nothing is observable, or empty
  int num_features = 0, num_views = 0;
  double rms_px = 0;  ///< per coordinate
  /// Standard deviation of the white noise in x and y.
  Eigen::Vector2d noise_px = Eigen::Vector2d::Zero();
  double noise = 0;  ///< fraction of the squared residuals
  double large = 0;  ///< fraction in excess of errors of five sigma
  std::array<CauseShare, kNumErrorCauses> causes;
  /// Fraction explained by camera motion with a column-wise readout. Cameras
  /// read out rows, so this is a control: an actual cause must explain more.
  double column_delay = 0;
  bool is_column_delay_indistinguishable = false;
  double rest = 0;  ///< unexplained; may be negative
  BudgetSummary facts;

  const CauseShare& Of(ErrorCause cause) const {
    return causes[static_cast<size_t>(cause)];
  }
  /// Returns the sum of all per-view causes.
  double PerViewShare() const;
};

/// Computes the budget; deterministic on any machine.
ResidualBudget ComputeResidualBudget(const BudgetInput& input);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_RESIDUAL_BUDGET_H
