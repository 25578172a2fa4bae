#include "adjustment/distortion_prior.h"

#include <cmath>
#include <vector>

#include "adjustment/matern_field.h"
#include "camera/central_radial.h"
#include "camera/decentring.h"

namespace raygrid {
namespace {

// Returns the prior of independent parameters, each scaled by the displacement
// in pixels that a unit of it causes; 0 for parameters outside the group.
PriorGroup MakeCoefficientGroup(const Eigen::VectorXd& pixels) {
  PriorGroup group;
  group.precision.resize(pixels.size(), pixels.size());
  for (Eigen::Index k = 0; k < pixels.size(); ++k) {
    if (pixels[k] == 0) continue;
    group.precision.insert(k, k) = pixels[k] * pixels[k];
    ++group.rank;
  }
  return group;
}

PriorGroup MakeDecentringGroup(const ParametricModel& lens, const Area& area,
                               int num_features) {
  PriorGroup group =
      MakeCoefficientGroup(ComputeDecentringDisplacement(lens, area));
  // The factor 2 accounts for the two coordinates of a residual.
  group.precision_floor =
      2.0 * num_features * kMaxDecentringFraction * kMaxDecentringFraction;
  return group;
}

// Returns the Matern prior over the angle of incidence, for the displacement in
// pixels.
PriorGroup MakeRadialGroup(const CentralRadial& lens) {
  const int count = static_cast<int>(lens.spline().size());
  const double kappa = MaternKappa(lens.max_angle_rad(), lens.cell_rad());
  std::vector<Eigen::Triplet<double>> triplets;
  int num_rows = 0;
  for (int order = 0; order <= kMaternOrder; ++order) {
    const double factor = std::sqrt(Binomial(kMaternOrder, order)) *
                          std::pow(kappa, kMaternOrder - order);
    for (int first = 0; first + order < count; ++first, ++num_rows)
      for (int k = 0; k <= order; ++k)
        triplets.emplace_back(num_rows, first + k,
                              factor * DifferenceFactor(order, k) *
                                  lens.others()[CentralRadial::kFx] *
                                  (first + k + 1) * lens.cell_rad());
  }
  const int num_parameters = lens.NumParameters();
  Eigen::SparseMatrix<double> rows(num_rows, num_parameters);
  rows.setFromTriplets(triplets.begin(), triplets.end());
  PriorGroup group;
  group.precision = rows.transpose() * rows;
  group.rank = count;
  return group;
}

}  // namespace

CameraPrior MakeDistortionPrior(const ParametricModel& lens, const Area& area,
                                int num_features) {
  const Eigen::VectorXd parameters = lens.Parameters();
  const int num_parameters = lens.NumParameters();
  CameraPrior prior;
  prior.mean = Eigen::VectorXd::Zero(num_parameters);
  prior.orientation = Eigen::MatrixXd::Zero(num_parameters, 0);

  if (const auto* radial = dynamic_cast<const CentralRadial*>(&lens)) {
    const int first = FirstCommonParameter(lens);
    prior.mean.head(first) = parameters.head(first);
    prior.groups.push_back(MakeRadialGroup(*radial));
  } else {
    prior.groups.push_back(
        MakeCoefficientGroup(ComputeRadialDisplacement(lens, area)));
  }
  PriorGroup decentring = MakeDecentringGroup(lens, area, num_features);
  if (decentring.rank > 0) prior.groups.push_back(std::move(decentring));
  return prior;
}

}  // namespace raygrid
