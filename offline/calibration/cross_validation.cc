#include "calibration/cross_validation.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <set>

#include "calibration/camera_evaluation.h"
#include "calibration/model_adjustment.h"
#include "calibration/starting_camera.h"
#include "camera/noncentral_generic.h"
#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

constexpr size_t kFolds = 4;
constexpr int kMaxGridParameters = 2600;  // tried
// The coarsest resolution whose loss is within this part of the best is chosen.
constexpr double kAsGoodAs = 0.005;

}  // namespace

Split SplitImages(const Dataset& dataset,
                  const std::function<bool(size_t)>& is_test) {
  Split split;
  split.training.image_size = split.test.image_size = dataset.image_size;
  for (size_t i = 0; i < dataset.images.size(); ++i)
    (is_test(i) ? split.test : split.training)
        .images.push_back(dataset.images[i]);
  return split;
}

Split SplitImages(const Dataset& dataset,
                  const std::vector<std::string>& test_images) {
  const std::set<std::string> names(test_images.begin(), test_images.end());
  return SplitImages(dataset, [&](size_t i) {
    return names.count(dataset.images[i].image) > 0;
  });
}

int NumFoldsToTry(const Dataset& dataset) {
  if (dataset.images.size() < 2 * kFolds) return 0;
  return dataset.images.size() <= 40 ? kFolds : 1;
}

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

std::vector<Trial> CrossValidate(const Dataset& dataset, const Pattern& pattern,
                                 const ValidationOptions& options,
                                 const std::vector<double>& cells) {
  const int num_folds = NumFoldsToTry(dataset);
  const int num_cells = static_cast<int>(cells.size());
  AdjustmentOptions serial;
  serial.num_threads = 1;
  serial.fix_points = options.flat_board;

  std::vector<Split> splits;
  std::vector<Adjusted> starts(num_folds);
  for (int fold = 0; fold < num_folds; ++fold)
    splits.push_back(SplitImages(dataset, [fold](size_t i) {
      return i % kFolds == static_cast<size_t>(fold);
    }));
  ParallelFor(num_folds, NumThreads(options.num_threads), [&](int fold) {
    starts[fold] = AdjustStart(splits[fold].training, pattern, serial);
  });

  std::vector<Evaluation> evaluations(num_folds * num_cells);
  int num_done = 0;
  std::mutex mutex;
  ParallelFor(num_folds * num_cells, NumThreads(options.num_threads),
              [&](int i) {
                const int fold = i / num_cells;
                Adjusted adjusted = starts[fold];
                AdjustModel(pattern, options.model, {cells[i % num_cells]},
                            serial, &adjusted);
                AlignBoards(pattern, &adjusted);
                evaluations[i] =
                    EvaluateCamera(adjusted.state.camera(), splits[fold].test,
                                   AdjustedPattern(pattern, adjusted), 1);
                const std::lock_guard<std::mutex> lock(mutex);
                if (options.progress)
                  options.progress(static_cast<double>(++num_done) /
                                   (num_folds * num_cells));
              });

  std::vector<Trial> trials(num_cells);
  for (int i = 0; i < num_folds * num_cells; ++i) {
    Trial& trial = trials[i % num_cells];
    trial.cell_px = cells[i % num_cells];
    trial.held_out.insert(trial.held_out.end(),
                          evaluations[i].residuals.begin(),
                          evaluations[i].residuals.end());
  }
  return trials;
}

CellCandidate Summarize(const Trial& trial) {
  CellCandidate candidate;
  candidate.cell_px = trial.cell_px;
  std::vector<double> norms;
  for (const FeatureResidual& residual : trial.held_out) {
    norms.push_back(residual.error_px.norm());
    candidate.loss +=
        HuberLoss(norms.back(), 1) / static_cast<double>(trial.held_out.size());
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
