#include "calibration/deformation_selection.h"

#include <vector>

#include "calibration/knot_spacing_search.h"
#include "calibration/knot_spacing_selection.h"
#include "camera/model_fitting.h"

namespace raygrid {
namespace {

// Whether deformation can reduce the squared errors by at least the given
// fraction, estimated from the residuals of cameras with rigid boards.
bool CanDeform(const std::vector<Trial>& trials, double knot_spacing_px,
               double part) {
  double sum = 0, count = 0;
  for (const Trial& trial : trials) {
    if (!trial.rigid_boards ||
        trial.knot_spacings_px.front() != knot_spacing_px)
      continue;
    sum += trial.deformation_share;
    ++count;
  }
  return sum > part * count;
}

// Gains from estimating deformation, in standard deviations; 1 if a single
// image causes the entire gain.
struct HeldOutZScores {
  double alone, with_deformation;
  double Sum() const { return alone + with_deformation; }
};

HeldOutZScores ComputeZScores(const HeldOutResiduals& deformed_residuals,
                              const HeldOutResiduals& rigid) {
  return {
      ComputeLossZScore(rigid.alone.front(), deformed_residuals.alone.front()),
      ComputeLossZScore(rigid.with_deformation.front(),
                        deformed_residuals.with_deformation.front())};
}

// Keeps a knot spacing that is coarser than the medium one only if it also
// predicts deformed boards significantly better; with rigid boards, deformation
// acts as noise and favours coarse grids.
void ReselectKnotSpacing(const Pattern& pattern,
                         const CalibrationOptions& options,
                         const ValidationOptions& validation,
                         CameraInProgress* camera) {
  if (options.knot_spacing_px > 0) return;
  Folds& folds = camera->folds;
  std::vector<Trial>& trials = camera->checkpoint.trials;
  const auto evaluate_deformed = [&](double knot_spacing_px) {
    CrossValidate(pattern, validation, {{knot_spacing_px}}, &folds, &trials);
    return JoinFolds(trials, folds.count(), {knot_spacing_px}, false)
        .with_deformation;
  };
  const Dataset& images = camera->split.training;
  double& chosen_px = camera->result.knot_spacing_px;
  for (const double finer_px : ListKnotSpacings(images, options.model)) {
    if (finer_px >= chosen_px ||
        finer_px < MediumKnotSpacingPx(images, options.model))
      continue;
    const auto coarser = evaluate_deformed(chosen_px),
               finer = evaluate_deformed(finer_px);
    if (coarser.empty() || finer.empty() ||
        ComputeLossZScore(finer.front(), coarser.front()) >= kMinCoarserZScore)
      return;
    chosen_px = finer_px;
  }
}

}  // namespace

bool IsDeformationBetter(const HeldOutResiduals& deformed_residuals,
                         const HeldOutResiduals& rigid) {
  constexpr double kMinZScore = -1.5, kMinZScoreSum = 1;
  const HeldOutZScores z_scores = ComputeZScores(deformed_residuals, rigid);
  return z_scores.with_deformation > 0 && z_scores.alone > kMinZScore &&
         z_scores.Sum() > kMinZScoreSum;
}

void SelectDeformation(const Pattern& pattern,
                       const CalibrationOptions& options,
                       CameraInProgress* camera) {
  // Deformation explains a larger fraction of training residuals than of
  // held-out residuals.
  constexpr double kMinDeformationShare = 0.01;
  camera->per_view_deformation = false;
  if (options.rigid_board || options.fix_target_geometry ||
      IsParametricModel(options.model))
    return;
  Folds& folds = camera->folds;
  const double knot_spacing_px = camera->result.knot_spacing_px;
  std::vector<Trial>& trials = camera->checkpoint.trials;
  ValidationOptions validation = MakeValidationOptions(options);
  validation.on_done = [camera] { camera->Save(); };
  const auto held_out = [&](int num_folds, bool rigid) {
    validation.rigid_boards = rigid;
    validation.keep_rigid = rigid;
    validation.num_folds = num_folds;
    CrossValidate(pattern, validation, {{knot_spacing_px}}, &folds, &trials);
    return JoinFolds(trials, num_folds, {knot_spacing_px}, rigid);
  };
  const int all = folds.count(), half = (all + 1) / 2;
  const HeldOutResiduals rigid = held_out(all, true);
  if (!CanDeform(trials, knot_spacing_px, kMinDeformationShare) ||
      rigid.with_deformation.empty())
    return;
  const HeldOutResiduals part = held_out(half, false);
  if (part.with_deformation.empty() ||
      ComputeZScores(part, JoinFolds(trials, half, {knot_spacing_px}, true))
              .Sum() <= 0)
    return;
  const HeldOutResiduals deformed_residuals = held_out(all, false);
  if (deformed_residuals.with_deformation.empty()) return;
  camera->per_view_deformation = IsDeformationBetter(deformed_residuals, rigid);
  if (camera->per_view_deformation)
    ReselectKnotSpacing(pattern, options, validation, camera);
}

}  // namespace raygrid
