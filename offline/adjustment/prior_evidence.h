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

/// The evidence on a group of parameters under the prior: how many of them
/// there are, how many the observations determine, and their squared distance
/// from the prior's mean (in K's metric).
struct GroupEvidence {
  double count = 0, determined = 0, squared_distance = 0;
};

/// A group of the prior, with the place of its camera among the parameters.
struct CameraGroup {
  int camera = 0;
  PriorGroup* group = nullptr;
  PrecisionRoot root;
};

/// The groups of all cameras. The prior must outlive them.
std::vector<CameraGroup> CameraGroups(GaussianPrior* prior);

/// The evidence of each group of the prior.
struct PriorEvidence {
  std::vector<GroupEvidence> groups;  ///< of cameras
  GroupEvidence points;               ///< those that are seen
  std::array<GroupEvidence, kNumBendOrders> flex;
};

/// How many of the points are in any view.
int NumSeenPoints(const std::vector<View>& views, size_t num_points);

/// The evidence of observations on a prior's strength (MacKay, "Bayesian
/// Interpolation", 1992). equations: of the views, damped by lambda. Nothing if
/// the system is singular.
std::optional<PriorEvidence> EvidenceOn(
    const std::vector<CameraGroup>& groups, const GaussianPrior& prior,
    const std::vector<View>& views, const NormalEquations& equations,
    const ParameterLayout& layout, double lambda, const AdjustmentState& state);

/// Whether the observations tell next to nothing of a group.
bool IsNextToNothing(const GroupEvidence& evidence);

/// Whether the evidence is greater with a larger variance of the prior.
bool ScattersMore(const GroupEvidence& evidence, double prior_variance);

/// Whether parameters depart so little from their mean as chance lets 1 of 50
/// of them.
bool IsByChance(const GroupEvidence& evidence, double prior_variance);

/// Moves a weight round by round to where the evidence leaves it.
class WeightUpdate {
 public:
  /// The variance of the group's parameters is taken for no smaller than
  /// smallest_variance, the weight for no smaller than least_weight. Returns
  /// how much the weight's logarithm changed.
  double Update(const GroupEvidence& group, double residual_variance,
                double smallest_variance, double least_weight, double* weight);

 private:
  static constexpr double kMaxFactor = 0.8;
  double last_change_ = 0;  // none, or of which none is known
};

/// Moves the weight of parameters that scatter independently, and that the
/// observations tell about as well of one as of another. Where these leave
/// nothing of a scatter, weights as above grow by as much in each round.
class ScatterUpdate {
 public:
  /// Returns how much the weight's logarithm changed. The parameters' variance
  /// is taken for no smaller than smallest_variance.
  double Update(const GroupEvidence& group, double residual_variance,
                double smallest_variance, double* weight);

 private:
  double last_step_ = 0, exponent_ = 1;
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_PRIOR_EVIDENCE_H
