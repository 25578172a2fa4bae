#include "calibration/grid_choice.h"

#include <algorithm>
#include <cmath>

#include "adjustment/bundle_adjustment.h"
#include "camera/noncentral_generic.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

constexpr int kMaxGridParameters = 2600;  // tried
// The coarsest resolution whose loss is within this part of the best is chosen.
constexpr double kAsGoodAs = 0.005;

}  // namespace

std::vector<double> CellCandidates(const Dataset& dataset,
                                   const std::string& model) {
  const int per_node =
      model == "noncentral-generic" ? NonCentralGeneric::kPerNode : 2;
  const double longer =
      std::max(dataset.image_size.width, dataset.image_size.height);
  const double shorter =
      std::min(dataset.image_size.width, dataset.image_size.height);
  std::vector<double> candidates;
  for (const int cells : {4, 8, 16, 24}) {
    const double cell_px = longer / cells;
    const int parameters = per_node * NumControlPoints(longer, cell_px) *
                           NumControlPoints(shorter, cell_px);
    if (candidates.empty() ||
        (parameters < kMaxGridParameters &&
         parameters < 2 * static_cast<int>(dataset.num_features())))
      candidates.push_back(cell_px);
  }
  return candidates;
}

CellCandidate Summarize(double cell_px,
                        const std::vector<FeatureResidual>& held_out) {
  CellCandidate candidate;
  candidate.cell_px = cell_px;
  std::vector<double> norms;
  for (const FeatureResidual& residual : held_out) {
    norms.push_back(residual.error_px.norm());
    candidate.loss +=
        HuberLoss(norms.back(), 1) / static_cast<double>(held_out.size());
  }
  candidate.median_px = Quantile(norms, 0.5);
  if (norms.empty()) candidate.loss = INFINITY;  // nothing could be localised
  return candidate;
}

size_t ChooseCandidate(const std::vector<CellCandidate>& candidates) {
  double best = INFINITY;
  for (const CellCandidate& candidate : candidates)
    best = std::min(best, candidate.loss);
  size_t chosen = 0;
  while (candidates[chosen].loss > (1 + kAsGoodAs) * best) ++chosen;
  return chosen;
}

}  // namespace raygrid
