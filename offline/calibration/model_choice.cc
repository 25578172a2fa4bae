#include "calibration/model_choice.h"

#include <algorithm>
#include <limits>

#include "calibration/cell_search.h"
#include "calibration/grid_choice.h"
#include "camera/lens_models.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

using models::kCentralGeneric;
using models::kNonCentralGeneric;

// Gains over the central grid, in standard errors.
constexpr double kParametricGain = 1, kNoncentralGain = 2;

// One camera's cross-validation of several models.
class ModelComparison {
 public:
  ModelComparison(const Pattern& pattern, const CalibrationOptions& options,
                  CameraInProgress* camera)
      : pattern_(pattern), options_(options), camera_(camera) {
    if (camera->folds.count() > 0) {
      grid_ = JoinFolds(camera->checkpoint.trials, camera->folds.count(),
                        {camera->result.cell_px}, !camera->boards_bend);
      folds_ = camera->folds;
    } else {
      folds_ =
          MakeLeaveOneOutFolds({camera->split}, {&camera->lens.state.camera()});
      folds_.base_model = camera->lens.problem.base_model;
      grid_ = CrossValidated(kCentralGeneric, camera->result.cell_px);
    }
    AddCandidate(kCentralGeneric, grid_, 0);
    if (IsValid())
      grid_median_px_ = Summarize(0, grid_.alone.front()).median_px;
  }

  bool IsValid() const { return HasResiduals(grid_); }

  // In standard errors; minus infinity for a model that fails.
  double GainOf(const std::string& model, double cell_px) {
    const HeldOut held_out = CrossValidated(model, cell_px);
    if (!HasResiduals(held_out))
      return -std::numeric_limits<double>::infinity();
    const double gain =
        GainOver(grid_.alone.front(), held_out.alone.front(), grid_median_px_);
    AddCandidate(model, held_out, gain);
    return gain;
  }

 private:
  static bool HasResiduals(const HeldOut& held_out) {
    return !held_out.alone.empty() && !held_out.alone.front().empty();
  }

  HeldOut CrossValidated(const std::string& model, double cell_px) {
    ValidationOptions validation = ValidationOptionsOf(options_);
    validation.model = model;
    validation.rigid_boards =
        model != kNonCentralGeneric || !camera_->boards_bend;
    std::vector<Trial> trials;
    try {
      CrossValidate(pattern_, validation, {{cell_px}}, &folds_, &trials);
    } catch (const Error&) {
      return {};  // views that the model cannot describe
    }
    return JoinFolds(trials, folds_.count(), {cell_px},
                     validation.rigid_boards);
  }

  void AddCandidate(const std::string& model, const HeldOut& held_out,
                    double gain) {
    if (!HasResiduals(held_out)) return;
    const CellCandidate summary = Summarize(0, held_out.alone.front());
    camera_->result.model_candidates.push_back(
        {model, summary.loss, summary.median_px, gain});
  }

  const Pattern& pattern_;
  const CalibrationOptions& options_;
  CameraInProgress* camera_;
  Folds folds_;
  HeldOut grid_;
  // Losses are Huber's of this, so that a few outliers do not decide.
  double grid_median_px_ = 1;
};

}  // namespace

std::string ChooseModel(const Pattern& pattern,
                        const CalibrationOptions& options,
                        std::vector<CameraInProgress>* cameras) {
  std::vector<ModelComparison> comparisons;
  for (CameraInProgress& camera : *cameras) {
    comparisons.emplace_back(pattern, options, &camera);
    if (!comparisons.back().IsValid()) return kCentralGeneric;
  }
  // The least gain of all cameras counts.
  const auto gain_of = [&](const std::string& model, bool is_grid) {
    double least = std::numeric_limits<double>::infinity();
    for (size_t c = 0; c < cameras->size(); ++c) {
      const CameraInProgress& camera = (*cameras)[c];
      const double cell_px =
          is_grid ? std::max(camera.result.cell_px,
                             MediumCellPx(camera.split.training, model))
                  : 0;
      least = std::min(least, comparisons[c].GainOf(model, cell_px));
    }
    return least;
  };
  std::string best = kCentralGeneric;
  double best_gain = kParametricGain;
  for (const std::string& model : LensNames(ModelUse::kAuto)) {
    if (options.ShouldStop()) return kCentralGeneric;
    const double gain = gain_of(model, false);
    if (gain <= best_gain) continue;
    best = model;
    best_gain = gain;
  }
  if (options.allow_noncentral && best == kCentralGeneric &&
      !options.ShouldStop() &&
      gain_of(kNonCentralGeneric, true) >= kNoncentralGain)
    best = kNonCentralGeneric;
  return best;
}

}  // namespace raygrid
