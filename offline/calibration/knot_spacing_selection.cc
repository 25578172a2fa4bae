#include "calibration/knot_spacing_selection.h"

#include <algorithm>
#include <cmath>

#include "adjustment/reprojection_error.h"
#include "calibration/knot_spacing_search.h"
#include "camera/model_registry.h"
#include "camera/noncentral_generic.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

constexpr int kMaxGridParameters = 40000;
constexpr int kMedium = 2;  // index of the medium candidate

}  // namespace

std::vector<double> ListKnotSpacings(const Dataset& dataset,
                                     const std::string& model) {
  const int per_node =
      model == models::kNonCentralGeneric ? NonCentralGeneric::kPerNode : 2;
  const double longer =
      std::max(dataset.image_size.width, dataset.image_size.height);
  const double shorter =
      std::min(dataset.image_size.width, dataset.image_size.height);
  std::vector<double> candidates;
  for (const int cells : {4, 8, 16, 24, 32, 48, 64, 96, 128}) {
    const double knot_spacing_px = longer / cells;
    const int parameters = per_node *
                           NumControlPoints(longer, knot_spacing_px) *
                           NumControlPoints(shorter, knot_spacing_px);
    if (candidates.empty() ||
        (parameters < kMaxGridParameters &&
         parameters < 2 * static_cast<int>(dataset.num_features())))
      candidates.push_back(knot_spacing_px);
  }
  return candidates;
}

double MediumKnotSpacingPx(const Dataset& dataset, const std::string& model) {
  const std::vector<double> cells = ListKnotSpacings(dataset, model);
  return cells[std::min<size_t>(kMedium, cells.size() - 1)];
}

KnotSpacingCandidate SummarizeCandidate(
    double knot_spacing_px, const std::vector<FeatureResidual>& held_out) {
  KnotSpacingCandidate candidate;
  candidate.knot_spacing_px = knot_spacing_px;
  std::vector<double> norms;
  for (const FeatureResidual& residual : held_out) {
    norms.push_back(residual.error_px.norm());
    candidate.loss +=
        HuberLoss(norms.back(), 1) / static_cast<double>(held_out.size());
  }
  candidate.median_px = Quantile(norms, 0.5);
  if (norms.empty()) candidate.loss = INFINITY;  // no pose could be estimated
  return candidate;
}

void SelectKnotSpacing(const Pattern& pattern,
                       const CalibrationOptions& options,
                       const std::function<void(double)>& progress,
                       CameraInProgress* camera) {
  CalibrationResult& result = camera->result;
  if (IsParametricModel(options.model)) return;
  result.knot_spacing_px = options.knot_spacing_px;
  if (options.knot_spacing_px > 0) return;
  const std::vector<double> cells =
      ListKnotSpacings(camera->split.training, options.model);
  result.knot_spacing_px = cells.front();
  const int num_folds = camera->folds.count();
  if (num_folds == 0) return;

  camera->folds.knot_spacing_levels_px = cells;
  camera->folds.medium_level =
      std::min(kMedium, static_cast<int>(cells.size()) - 1);
  std::vector<Trial>& trials = camera->checkpoint.trials;
  ValidationOptions validation = MakeValidationOptions(options);
  validation.keep_rigid = true;
  validation.on_done = [camera] { camera->Save(); };
  // The total number of candidates is not known in advance, so progress covers
  // half of the remainder each time.
  double done = 0;
  const auto measure = [&](const std::vector<int>& which) {
    const double left = 1 - done;
    validation.progress = [&](double part) {
      done = 1 - left * (1 - part / 2);
      progress(done);
    };
    std::vector<std::vector<double>> each;
    for (const int i : which) each.push_back({cells[i]});
    CrossValidate(pattern, validation, each, &camera->folds, &trials);
    std::vector<std::vector<FeatureResidual>> measured;
    for (const std::vector<double>& knot_spacing_px : each) {
      HeldOutResiduals held_out =
          JoinFolds(trials, num_folds, knot_spacing_px, true);
      if (held_out.alone.empty()) break;
      measured.push_back(std::move(held_out.alone.front()));
    }
    return measured;
  };
  const auto probe = [&](int i) {
    ValidationOptions part = validation;
    part.num_folds = num_folds / 2;
    CrossValidate(pattern, part, {{cells[i]}}, &camera->folds, &trials);
    HeldOutResiduals held_out =
        JoinFolds(trials, part.num_folds, {cells[i]}, true);
    return held_out.alone.empty() ? std::vector<FeatureResidual>()
                                  : std::move(held_out.alone.front());
  };
  const std::optional<KnotSpacingSearch> search = KnotSpacingSearch::Run(
      static_cast<int>(cells.size()), kMedium, measure,
      num_folds > 1 ? probe : KnotSpacingSearch::Probe());
  if (!search) return;
  result.knot_spacing_px = cells[search->chosen];
  for (const auto& [candidate, residuals] : search->tried)
    result.knot_spacing_candidates.push_back(
        SummarizeCandidate(cells[candidate], residuals));
}

}  // namespace raygrid
