#ifndef RAYGRID_ADJUSTMENT_PRIOR_EVIDENCE_H
#define RAYGRID_ADJUSTMENT_PRIOR_EVIDENCE_H

#include <array>
#include <optional>
#include <vector>

#include "adjustment/adjustment_state.h"
#include "adjustment/gaussian_prior.h"
#include "adjustment/normal_equations.h"
#include "adjustment/precision_root.h"

namespace raygrid {

/// The evidence for a group's precision: number of parameters, effective
/// number, and squared distance from the prior mean (in K's metric).
struct GroupEvidence {
  double count = 0, effective_parameters = 0, squared_distance = 0;
};

/// A group of the prior, and the index of its camera's parameters.
struct CameraGroup {
  int camera = 0;
  PriorGroup* group = nullptr;
  PrecisionRoot root;
};

/// Lists the groups of all cameras. The prior must outlive them.
std::vector<CameraGroup> MakeCameraGroups(GaussianPrior* prior);

/// The evidence for each group of the prior.
struct PriorEvidence {
  std::vector<GroupEvidence> groups;  ///< by camera group
  GroupEvidence points;               ///< observed points only
  std::array<GroupEvidence, kNumDeformationOrders> flex;
};

/// Returns the number of points that are observed in any view.
int CountObservedPoints(const std::vector<View>& views, size_t num_points);

/// Computes the evidence for the prior precisions (MacKay, "Bayesian
/// Interpolation", 1992). equations: normal equations of the views, damped by
/// lambda. Returns nullopt if the system is singular.
std::optional<PriorEvidence> ComputeEvidence(
    const std::vector<CameraGroup>& groups, const GaussianPrior& prior,
    const std::vector<View>& views, const NormalEquations& equations,
    const ParameterLayout& layout, double lambda, const AdjustmentState& state);

/// Returns whether a group's effective number of parameters is near zero.
bool IsUndetermined(const GroupEvidence& evidence);

/// Returns whether the evidence increases with the prior variance.
bool FavorsLargerVariance(const GroupEvidence& evidence, double prior_variance);

/// Returns whether the parameters' departure from the prior mean is
/// insignificant (p >= 0.02).
bool IsInsignificant(const GroupEvidence& evidence, double prior_variance);

/// Updates a precision iteratively towards its fixed point.
class PrecisionUpdate {
 public:
  /// The variance of the group's parameters is bounded below by
  /// smallest_variance, the precision by min_precision. Returns the change of
  /// log precision.
  double Update(const GroupEvidence& group, double residual_variance,
                double smallest_variance, double min_precision, double* weight);

 private:
  static constexpr double kMaxFactor = 0.8;
  double last_change_ = 0;  // 0: none, or not computed
};

/// Updates the precision of independent parameters of similar observability. If
/// the estimated variance tends to zero, fixed-point steps of the log precision
/// become constant; this update accelerates them.
class VarianceUpdate {
 public:
  /// Returns the change of the log precision. The variance is bounded below by
  /// smallest_variance.
  double Update(const GroupEvidence& group, double residual_variance,
                double smallest_variance, double* weight);

 private:
  double last_step_ = 0, exponent_ = 1;
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_PRIOR_EVIDENCE_H
