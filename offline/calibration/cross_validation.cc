#include "calibration/cross_validation.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <set>

#include "calibration/camera_evaluation.h"
#include "calibration/model_adjustment.h"
#include "calibration/starting_lens.h"
#include "camera/noncentral_generic.h"
#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

constexpr size_t kFolds = 4;
static_assert(kCrossValidatingPart == 1 - 1.0 / kFolds);
constexpr int kMaxGridParameters = 2600;  // tried
// The coarsest resolution whose loss is within this part of the best is chosen.
constexpr double kAsGoodAs = 0.005;

const Checkpoint::Trial* Find(const std::vector<Checkpoint::Trial>& trials,
                              int fold, double cell_px) {
  for (const Checkpoint::Trial& trial : trials)
    if (trial.fold == fold && trial.cell_px == cell_px) return &trial;
  return nullptr;
}

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

void CrossValidate(const Dataset& dataset, const Pattern& pattern,
                   const ValidationOptions& options,
                   const std::vector<double>& cells,
                   std::vector<Checkpoint::Trial>* done) {
  const int num_folds = NumFoldsToTry(dataset);
  const int num_threads = NumThreads(options.num_threads);
  AdjustmentOptions serial;
  serial.num_threads = 1;
  serial.fix_points = options.flat_board;
  const auto should_stop = [&options] {
    return options.should_stop && options.should_stop();
  };

  std::vector<Split> splits;
  for (int fold = 0; fold < num_folds; ++fold)
    splits.push_back(SplitImages(dataset, [fold](size_t i) {
      return i % kFolds == static_cast<size_t>(fold);
    }));
  std::vector<Checkpoint::Trial> missing;
  std::vector<bool> is_fold_needed(num_folds, false);
  for (int fold = 0; fold < num_folds; ++fold) {
    for (const double cell_px : cells) {
      if (Find(*done, fold, cell_px)) continue;
      missing.push_back({fold, cell_px, {}});
      is_fold_needed[fold] = true;
    }
  }
  std::vector<Adjusted> starts(num_folds);
  ParallelFor(num_folds, num_threads, [&](int fold) {
    if (is_fold_needed[fold] && !should_stop())
      starts[fold] = AdjustStartingLens(splits[fold].training, pattern, serial);
  });

  serial.should_stop = options.should_stop;
  int num_done = 0;
  std::mutex mutex;
  ParallelFor(static_cast<int>(missing.size()), num_threads, [&](int i) {
    Checkpoint::Trial& trial = missing[i];
    Adjusted adjusted = starts[trial.fold];
    if (should_stop()) return;
    AdjustModel(pattern, options.model, {trial.cell_px}, serial, &adjusted);
    if (should_stop()) return;
    AlignBoards(pattern, &adjusted);
    trial.held_out =
        EvaluateCamera(adjusted.state.camera(), splits[trial.fold].test,
                       AdjustedPattern(pattern, adjusted), 1)
            .residuals;
    const std::lock_guard<std::mutex> lock(mutex);
    done->push_back(std::move(trial));
    if (options.on_done) options.on_done();
    if (options.progress)
      options.progress(static_cast<double>(++num_done) /
                       static_cast<double>(missing.size()));
  });
}

std::vector<Trial> JoinFolds(const std::vector<Checkpoint::Trial>& done,
                             int num_folds, const std::vector<double>& cells) {
  std::vector<Trial> trials;
  for (const double cell_px : cells) {
    Trial joined = {cell_px, {}};
    for (int fold = 0; fold < num_folds; ++fold) {
      const Checkpoint::Trial* trial = Find(done, fold, cell_px);
      if (!trial) return {};
      joined.held_out.insert(joined.held_out.end(), trial->held_out.begin(),
                             trial->held_out.end());
    }
    trials.push_back(std::move(joined));
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
