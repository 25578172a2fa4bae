#include "calibration/grid_choice.h"

#include <algorithm>
#include <cmath>

#include "adjustment/bundle_adjustment.h"
#include "camera/model_fitting.h"
#include "camera/noncentral_generic.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

constexpr int kMaxGridParameters = 2600;  // tried
// The coarsest resolution whose loss is within this part of the best is chosen.
constexpr double kAsGoodAs = 0.005;

size_t ChooseCandidate(const std::vector<CellCandidate>& candidates) {
  double best = INFINITY;
  for (const CellCandidate& candidate : candidates)
    best = std::min(best, candidate.loss);
  size_t chosen = 0;
  while (candidates[chosen].loss > (1 + kAsGoodAs) * best) ++chosen;
  return chosen;
}

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

double MediumCellPx(const Dataset& dataset, const std::string& model) {
  constexpr size_t kMediumCandidate = 2;
  const std::vector<double> cells = CellCandidates(dataset, model);
  return cells[std::min(kMediumCandidate, cells.size() - 1)];
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

void ChooseGrid(const Pattern& pattern, const CalibrationOptions& options,
                const std::function<void(double)>& progress,
                CameraInProgress* camera) {
  CalibrationResult& result = camera->result;
  if (IsParametricModel(options.model)) return;
  result.cell_px = options.cell_px;
  if (options.cell_px > 0) return;
  const std::vector<double> cells =
      CellCandidates(camera->split.training, options.model);
  result.cell_px = cells.front();
  const int num_folds = camera->folds.count();
  if (num_folds == 0) return;

  std::vector<Trial>& trials = camera->checkpoint.trials;
  ValidationOptions validation = ValidationOptionsOf(options);
  validation.keep_rigid = true;
  validation.progress = progress;
  validation.on_done = [camera] { camera->Keep(); };
  std::vector<std::vector<double>> each;
  for (const double cell_px : cells) each.push_back({cell_px});
  CrossValidate(pattern, validation, each, &camera->folds, &trials);
  std::vector<CellCandidate> candidates;
  for (const double cell_px : cells) {
    const HeldOut held_out = JoinFolds(trials, num_folds, {cell_px}, true);
    if (held_out.alone.empty()) return;
    candidates.push_back(Summarize(cell_px, held_out.alone.front()));
  }
  result.cell_px = cells[ChooseCandidate(candidates)];
  result.cell_candidates = std::move(candidates);
}

}  // namespace raygrid
