#include "calibration/model_selection.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "calibration/knot_spacing_search.h"
#include "calibration/knot_spacing_selection.h"
#include "camera/model_registry.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

using models::kCentralGeneric;
using models::kNonCentralGeneric;

// Minimum gains over the central grid, in standard errors.
constexpr double kMinParametricZScore = 1, kMinNoncentralZScore = 2;

// Cross-validates several models of one camera.
class ModelComparison {
 public:
  ModelComparison(const Pattern& pattern, const CalibrationOptions& options,
                  CameraInProgress* camera)
      : pattern_(pattern), options_(options), camera_(camera) {
    if (camera->folds.count() > 0) {
      grid_ = JoinFolds(camera->checkpoint.trials, camera->folds.count(),
                        {camera->result.knot_spacing_px},
                        !camera->per_view_deformation);
      folds_ = camera->folds;
      trials_[kCentralGeneric] = camera->checkpoint.trials;
    } else {
      folds_ =
          MakeLeaveOneOutFolds({camera->split}, {&camera->lens.state.camera()});
      folds_.base_model = camera->lens.problem.base_model;
      folds_.whole = camera->folds.whole;
      grid_ = CrossValidated(kCentralGeneric, camera->result.knot_spacing_px);
    }
    AddCandidate(kCentralGeneric, grid_, 0);
    if (IsValid())
      grid_median_px_ = SummarizeCandidate(0, grid_.alone.front()).median_px;
  }

  bool IsValid() const { return HasResiduals(grid_); }

  // Whether the target is nominal for the grid.
  bool IsTargetNominal() {
    const AdjustmentResult& whole = OptimizeWhole(
        pattern_, kCentralGeneric, camera_->result.knot_spacing_px,
        MakeStoppableOptions(options_), &folds_);
    return !HavePointsMoved(whole) && !whole.state.HasStaticDeformation();
  }
  void FixTargetGeometry() { options_.fix_target_geometry = true; }

  // Trials of the camera's folds by model.
  const ModelTrials& trials() const { return trials_; }

  // Returns the gain over the central grid in standard errors; minus infinity
  // if the model fails.
  double ComputeZScore(const std::string& model, double knot_spacing_px) {
    const HeldOutResiduals held_out = CrossValidated(model, knot_spacing_px);
    if (!HasResiduals(held_out))
      return -std::numeric_limits<double>::infinity();
    const double z_score = ComputeLossZScore(
        grid_.alone.front(), held_out.alone.front(), grid_median_px_);
    AddCandidate(model, held_out, z_score);
    return z_score;
  }

 private:
  static bool HasResiduals(const HeldOutResiduals& held_out) {
    return !held_out.alone.empty() && !held_out.alone.front().empty();
  }

  HeldOutResiduals CrossValidated(const std::string& model,
                                  double knot_spacing_px) {
    ValidationOptions validation = MakeValidationOptions(options_);
    validation.model = model;
    validation.rigid_boards =
        model != kNonCentralGeneric || !camera_->per_view_deformation;
    std::vector<Trial> trials;
    try {
      CrossValidate(pattern_, validation, {{knot_spacing_px}}, &folds_,
                    &trials);
    } catch (const Error&) {
      return {};  // views that the model cannot represent
    }
    camera_->folds.whole_results = folds_.whole_results;
    if (camera_->folds.count() > 0) trials_[model] = trials;
    return JoinFolds(trials, folds_.count(), {knot_spacing_px},
                     validation.rigid_boards);
  }

  void AddCandidate(const std::string& model, const HeldOutResiduals& held_out,
                    double z_score) {
    if (!HasResiduals(held_out)) return;
    const KnotSpacingCandidate summary =
        SummarizeCandidate(0, held_out.alone.front());
    camera_->result.model_candidates.push_back(
        {model, summary.loss, summary.median_px, z_score});
  }

  const Pattern& pattern_;
  CalibrationOptions options_;
  CameraInProgress* camera_;
  Folds folds_;
  ModelTrials trials_;
  HeldOutResiduals grid_;
  // Huber threshold of the losses, so that a few outliers do not dominate.
  double grid_median_px_ = 1;
};

}  // namespace

ModelSelection SelectModel(const Pattern& pattern,
                           const CalibrationOptions& options,
                           std::vector<CameraInProgress>* cameras) {
  ModelSelection selection = {kCentralGeneric,
                              std::vector<ModelTrials>(cameras->size()),
                              options.fix_target_geometry};
  std::vector<ModelComparison> comparisons;
  std::vector<size_t> estimated;
  for (size_t c = 0; c < cameras->size(); ++c) {
    if ((*cameras)[c].HasKnownIntrinsics()) continue;
    estimated.push_back(c);
    comparisons.emplace_back(pattern, options, &(*cameras)[c]);
    if (!comparisons.back().IsValid()) return selection;
  }
  // As in the comparison of the final camera with other models, whose trials
  // are then known.
  if (!options.fix_target_geometry &&
      std::all_of(comparisons.begin(), comparisons.end(), [](auto& comparison) {
        return comparison.IsTargetNominal();
      })) {
    selection.fix_target_geometry = true;
    for (ModelComparison& comparison : comparisons)
      comparison.FixTargetGeometry();
  }
  // The smallest gain over all cameras decides.
  const auto compute_z_score = [&](const std::string& model, bool is_grid) {
    double min_error = std::numeric_limits<double>::infinity();
    for (size_t k = 0; k < estimated.size(); ++k) {
      const CameraInProgress& camera = (*cameras)[estimated[k]];
      const double knot_spacing_px =
          is_grid ? std::max(camera.result.knot_spacing_px,
                             MediumKnotSpacingPx(camera.split.training, model))
                  : 0;
      min_error = std::min(
          min_error, comparisons[k].ComputeZScore(model, knot_spacing_px));
    }
    return min_error;
  };
  std::string& best = selection.model;
  double best_z_score = kMinParametricZScore;
  for (const std::string& model : ListModelNames(ModelUse::kAuto)) {
    if (options.ShouldStop())
      return {kCentralGeneric, std::move(selection.trials),
              selection.fix_target_geometry};
    const double z_score = compute_z_score(model, false);
    if (z_score <= best_z_score) continue;
    best = model;
    best_z_score = z_score;
  }
  if (options.allow_noncentral && best == kCentralGeneric &&
      !options.ShouldStop() &&
      compute_z_score(kNonCentralGeneric, true) >= kMinNoncentralZScore)
    best = kNonCentralGeneric;
  for (size_t k = 0; k < estimated.size(); ++k)
    selection.trials[estimated[k]] = comparisons[k].trials();
  return selection;
}

}  // namespace raygrid
