#include "calibration/cross_validation.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>
#include <set>

#include "calibration/base_model.h"
#include "calibration/camera_evaluation.h"
#include "calibration/camera_initialization.h"
#include "calibration/deformation_evaluation.h"
#include "calibration/deformation_share.h"
#include "calibration/near_duplicates.h"
#include "calibration/rig_evaluation.h"
#include "calibration/rig_initialization.h"
#include "camera/fixed_camera.h"
#include "camera/model_fitting.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

constexpr size_t kFolds = 4;
static_assert(kTrainingFraction == 1 - 1.0 / kFolds);

const Trial* FindTrial(const std::vector<Trial>& trials, int fold,
                       const std::vector<double>& knot_spacings_px,
                       bool rigid_boards, bool has_rigid_targets) {
  for (const Trial& trial : trials)
    if (trial.fold == fold && trial.knot_spacings_px == knot_spacings_px &&
        trial.rigid_boards == rigid_boards &&
        trial.has_rigid_targets == has_rigid_targets)
      return &trial;
  return nullptr;
}

// Returns the unique names of the cameras' training images: in image order for
// one camera, sorted for a rig.
std::vector<std::string> ListTrainingFrames(const std::vector<Split>& cameras) {
  std::vector<std::string> frames;
  for (const Split& camera : cameras)
    for (const ImageFeatures& image : camera.training.images)
      frames.push_back(image.image);
  if (cameras.size() < 2) return frames;
  const std::set<std::string> sorted(frames.begin(), frames.end());
  return {sorted.begin(), sorted.end()};
}

// Groups frames by near-duplicates, which even a poor camera predicts well from
// each other. Groups are sorted by their first frame.
std::vector<std::vector<std::string>> GroupFrames(
    const std::vector<Split>& cameras) {
  std::vector<Dataset> datasets;
  double near_px = 0;
  for (const Split& camera : cameras) {
    datasets.push_back(camera.training);
    near_px = std::max(near_px, NearDuplicatePx(camera.training.image_size));
  }
  std::map<std::string, std::string> view_by_image;
  for (const NearDuplicates& group : FindNearDuplicates(datasets, {}, near_px))
    for (const std::string& other : group.others)
      view_by_image[other] = group.image;
  std::vector<std::vector<std::string>> views;
  std::map<std::string, size_t> index;
  for (const std::string& frame : ListTrainingFrames(cameras)) {
    const auto found = view_by_image.find(frame);
    const std::string& view =
        found == view_by_image.end() ? frame : found->second;
    const size_t i = index.emplace(view, views.size()).first->second;
    if (i == views.size()) views.emplace_back();
    views[i].push_back(frame);
  }
  return views;
}

std::vector<Trial> ListMissingTrials(
    int num_folds, const std::vector<std::vector<double>>& candidates,
    bool rigid_boards, bool has_rigid_targets, const std::vector<Trial>& done) {
  std::vector<Trial> missing;
  for (int fold = 0; fold < num_folds; ++fold)
    for (const std::vector<double>& knot_spacings_px : candidates)
      if (!FindTrial(done, fold, knot_spacings_px, rigid_boards,
                     has_rigid_targets))
        missing.push_back(
            {fold, knot_spacings_px, rigid_boards, {}, has_rigid_targets});
  return missing;
}

using KnownModels = std::vector<std::shared_ptr<const CameraModel>>;

AdjustmentResult InitializeCameras(const std::vector<Split>& cameras,
                                   const KnownModels& known,
                                   const Pattern& pattern,
                                   const RigidTargets& rigid_targets,
                                   AreaChoice area,
                                   const AdjustmentOptions& options) {
  std::vector<std::string> names;
  std::vector<AdjustmentResult> lenses;
  for (size_t c = 0; c < cameras.size(); ++c) {
    names.push_back(cameras[c].camera);
    lenses.push_back(IsFixed(*known[c])
                         ? InitializeKnownCamera(*known[c], cameras[c].training,
                                                 pattern, area,
                                                 options.num_threads)
                         : InitializeCamera(cameras[c].training, pattern,
                                            options, area, known[c].get()));
  }
  std::vector<std::vector<RejectedImage>> rejected;
  return InitializeRig(names, lenses, rigid_targets, options, &rejected);
}

// A rig with few connecting views may be disconnected if some of them are held
// out; the remaining work of that fold is skipped.
template <typename Work>
void SkipIfDisconnected(size_t num_cameras, const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    if (num_cameras < 2 || (error.code() != ExitCode::kInsufficientData &&
                            error.code() != ExitCode::kInitializationFailed))
      throw;
  }
}

// Returns the first `count` folds of a cross-validation with `num_folds` folds.
Folds SplitIntoFolds(const std::vector<std::vector<std::string>>& views,
                     const std::vector<Split>& cameras,
                     const std::vector<const CameraModel*>& known, size_t count,
                     size_t num_folds) {
  Folds folds;
  for (const CameraModel* lens : known) folds.known.push_back(lens->Clone());
  folds.folds.resize(count);
  for (size_t fold = 0; fold < count; ++fold) {
    std::vector<std::string> test;
    for (size_t i = fold; i < views.size(); i += num_folds)
      test.insert(test.end(), views[i].begin(), views[i].end());
    for (const Split& camera : cameras)
      folds.folds[fold].cameras.push_back(
          SplitImages(camera.camera, camera.training, test));
  }
  return folds;
}

// Returns the adjustment options for one of several concurrent adjustments,
// which share the threads.
AdjustmentOptions MakeFoldOptions(int num_adjustments,
                                  const ValidationOptions& options) {
  AdjustmentOptions adjustment;
  adjustment.num_threads = std::max(
      1, NumThreads(options.num_threads) / std::max(1, num_adjustments));
  adjustment.fix_points = options.fix_target_geometry;
  return adjustment;
}

// Initializes the folds that the trials need.
void StartFolds(const std::vector<Trial>& trials, const Pattern& pattern,
                const ValidationOptions& options, Folds* folds) {
  const bool is_grid = !IsParametricModel(options.model);
  std::vector<Folds::Fold*> needed;
  for (int k = 0; k < folds->count(); ++k) {
    Folds::Fold& fold = folds->folds[k];
    if (std::any_of(trials.begin(), trials.end(),
                    [k](const Trial& trial) { return trial.fold == k; }) &&
        !(is_grid ? fold.lenses : fold.start))
      needed.push_back(&fold);
  }
  const int count = static_cast<int>(needed.size());
  const AdjustmentOptions adjustment = MakeFoldOptions(count, options);
  ParallelFor(count, NumThreads(options.num_threads), [&](int i) {
    Folds::Fold& fold = *needed[i];
    if (options.should_stop && options.should_stop()) return;
    SkipIfDisconnected(fold.cameras.size(), [&] {
      if (!fold.start)
        fold.start =
            InitializeCameras(fold.cameras, folds->known, pattern,
                              options.rigid_targets, options.area, adjustment);
      fold.start->problem.base_model = folds->base_model;
      fold.start->problem.like = options.like;
      fold.start->problem.prior_population = options.prior_population;
      if (!is_grid) return;
      AdjustmentResult lenses = *fold.start;
      FitBaseModels(adjustment, &lenses);
      fold.lenses = std::move(lenses);
    });
  });
}

// Returns the knot spacing whose grid is the warm start in the same fold;
// nullopt if there is none.
std::optional<double> FindWarmSpacing(const Folds& folds,
                                      const std::string& model,
                                      double knot_spacing_px) {
  if (model != models::kCentralGeneric) return std::nullopt;
  const std::vector<double>& levels_px = folds.knot_spacing_levels_px;
  for (int i = 0; i < static_cast<int>(levels_px.size()); ++i)
    if (levels_px[i] == knot_spacing_px && i != folds.medium_level)
      return levels_px[i > folds.medium_level ? i - 1 : i + 1];
  return std::nullopt;
}

const AdjustmentResult* FindWholeResult(const Folds& folds,
                                        const std::string& model,
                                        double knot_spacing_px,
                                        bool fix_points) {
  for (const auto& result : folds.whole_results)
    if (result->model == model && result->knot_spacing_px == knot_spacing_px &&
        result->fix_points == fix_points)
      return &result->adjusted;
  return nullptr;
}

// Optimizes the cameras of a fold; nullopt if initialization failed. Results
// that were not checkpointed are recomputed, so that a resumed calibration
// gives identical results.
std::optional<AdjustmentResult> OptimizeFoldRigidly(
    const Folds& folds, const Folds::Fold& fold, const Pattern& pattern,
    const std::string& model, const std::vector<double>& knot_spacings_px,
    const AdjustmentOptions& options) {
  const bool is_grid = !IsParametricModel(model);
  for (const auto& [cells, kept] : fold.rigid)
    if (is_grid && cells == knot_spacings_px) return kept;
  std::optional<AdjustmentResult> adjusted = is_grid ? fold.lenses : fold.start;
  if (!adjusted) return adjusted;
  std::optional<AdjustmentResult> warm;
  if (knot_spacings_px.size() == 1) {
    if (const auto other_px =
            FindWarmSpacing(folds, model, knot_spacings_px.front()))
      warm = OptimizeFoldRigidly(folds, fold, pattern, model, {*other_px},
                                 options);
  }
  OptimizeWithRigidBoards(pattern, model, knot_spacings_px, options, &*adjusted,
                          warm ? &*warm : nullptr);
  return adjusted;
}

// Evaluates the optimized cameras on their test images.
HeldOutResiduals TestCameras(const AdjustmentResult& adjusted,
                             const Pattern& pattern,
                             const std::vector<Split>& cameras,
                             const RigidTargets& rigid_targets,
                             int num_threads) {
  const Pattern adjusted_pattern = MakeEstimatedPattern(pattern, adjusted);
  RigModel rig = {{}, adjusted.state.camera_from_rig, {}};
  if (!rigid_targets.empty())
    rig.rigid_targets = UpdateRigidTargets(rigid_targets, adjusted.problem,
                                           adjusted.state.target_from_board);
  std::vector<Dataset> test;
  HeldOutResiduals held_out;
  for (size_t c = 0; c < cameras.size(); ++c) {
    rig.cameras.push_back(adjusted.state.cameras[c].get());
    test.push_back(cameras[c].test);
    held_out.alone.push_back(
        EvaluateCamera(*rig.cameras[c], test[c], adjusted_pattern, num_threads)
            .residuals);
  }
  held_out.with_deformation =
      EvaluateWithDeformation(rig, test, adjusted_pattern, num_threads);
  if (cameras.size() < 2) return held_out;
  for (Evaluation& evaluation :
       EvaluateRig(rig, test, adjusted_pattern, num_threads))
    held_out.together.push_back(std::move(evaluation.residuals));
  return held_out;
}

}  // namespace

Split SplitImages(const std::string& camera, const Dataset& dataset,
                  const std::vector<std::string>& test_images) {
  const std::set<std::string> names(test_images.begin(), test_images.end());
  Split split = {camera, {}, {}};
  split.training.image_size = split.test.image_size = dataset.image_size;
  for (const ImageFeatures& image : dataset.images)
    (names.count(image.image) > 0 ? split.test : split.training)
        .images.push_back(image);
  return split;
}

Folds MakeFolds(const std::vector<Split>& cameras,
                const std::vector<const CameraModel*>& known) {
  constexpr size_t kManyViews = 40;
  const auto views = GroupFrames(cameras);
  if (views.size() < 2 * kFolds)
    return SplitIntoFolds(views, cameras, known, 0, 1);
  return SplitIntoFolds(views, cameras, known,
                        views.size() <= kManyViews ? kFolds : 1, kFolds);
}

Folds MakeLeaveOneOutFolds(const std::vector<Split>& cameras,
                           const std::vector<const CameraModel*>& known) {
  constexpr size_t kMinViews = 4;
  const auto views = GroupFrames(cameras);
  const size_t count = views.size() < kMinViews ? 0 : views.size();
  return SplitIntoFolds(views, cameras, known, count, count);
}

const AdjustmentResult& OptimizeWhole(const Pattern& pattern,
                                      const std::string& model,
                                      double knot_spacing_px,
                                      const AdjustmentOptions& options,
                                      Folds* folds) {
  if (const AdjustmentResult* known =
          FindWholeResult(*folds, model, knot_spacing_px, options.fix_points))
    return *known;
  AdjustmentResult adjusted = *folds->whole;
  if (!IsParametricModel(model)) FitBaseModels(options, &adjusted);
  OptimizeWithRigidBoards(pattern, model, {knot_spacing_px}, options,
                          &adjusted);
  folds->whole_results.push_back(
      std::make_shared<const Folds::WholeResult>(Folds::WholeResult{
          model, knot_spacing_px, options.fix_points, std::move(adjusted)}));
  return folds->whole_results.back()->adjusted;
}

AdjustmentResult OptimizeWholeModel(const Pattern& pattern,
                                    const std::string& model,
                                    double knot_spacing_px,
                                    const AdjustmentOptions& options,
                                    Folds* folds) {
  AdjustmentResult adjusted =
      OptimizeWhole(pattern, model, knot_spacing_px, options, folds);
  FinishModel(pattern, model, options, &adjusted);
  return adjusted;
}

void InitializeFolds(const Pattern& pattern, const ValidationOptions& options,
                     Folds* folds) {
  StartFolds(ListMissingTrials(folds->count(), {{}}, true, false, {}), pattern,
             options, folds);
}

void CrossValidate(const Pattern& pattern, const ValidationOptions& options,
                   const std::vector<std::vector<double>>& candidates,
                   Folds* folds, std::vector<Trial>* done) {
  const auto should_stop = [&options] {
    return options.should_stop && options.should_stop();
  };
  std::vector<Trial> missing = ListMissingTrials(
      options.num_folds > 0 ? options.num_folds : folds->count(), candidates,
      options.rigid_boards, !options.rigid_targets.empty(), *done);
  StartFolds(missing, pattern, options, folds);

  const int num_trials = static_cast<int>(missing.size());
  const int num_threads = NumThreads(options.num_threads);
  AdjustmentOptions adjustment = MakeFoldOptions(num_trials, options);
  adjustment.should_stop = options.should_stop;
  adjustment.rigid_boards = options.rigid_boards;
  std::vector<std::optional<AdjustmentResult>> rigid(missing.size());
  int num_done = 0;
  std::mutex mutex;
  ParallelFor(num_trials, num_threads, [&](int i) {
    Trial& trial = missing[i];
    const Folds::Fold& fold = folds->folds[trial.fold];
    if (should_stop()) return;
    SkipIfDisconnected(fold.cameras.size(), [&] {
      auto adjusted = OptimizeFoldRigidly(*folds, fold, pattern, options.model,
                                          trial.knot_spacings_px, adjustment);
      if (!adjusted) return;
      if (options.rigid_boards) {
        rigid[i] = *adjusted;
        trial.deformation_share =
            ComputeDeformationShare(*adjusted, adjustment.num_threads);
      } else if (!IsParametricModel(options.model)) {
        EstimateDeformation(pattern, adjustment, &*adjusted);
      }
      FinalizeCameras(&*adjusted);
      AlignBoards(pattern, &*adjusted);
      if (!should_stop())
        trial.held_out =
            TestCameras(*adjusted, pattern, fold.cameras, options.rigid_targets,
                        adjustment.num_threads);
    });
    if (should_stop()) return;
    const std::lock_guard<std::mutex> lock(mutex);
    done->push_back(trial);
    if (options.on_done) options.on_done();
    if (options.progress)
      options.progress(static_cast<double>(++num_done) /
                       static_cast<double>(missing.size()));
  });
  if (should_stop() || !options.keep_rigid) return;
  for (size_t i = 0; i < missing.size(); ++i)
    if (rigid[i])
      folds->folds[missing[i].fold].rigid.emplace_back(
          missing[i].knot_spacings_px, std::move(*rigid[i]));
}

HeldOutResiduals EvaluateHeldOut(const AdjustmentResult& adjusted,
                                 const Pattern& pattern,
                                 const std::vector<Split>& cameras,
                                 const ValidationOptions& options,
                                 const std::vector<double>& knot_spacings_px,
                                 Folds* folds, std::vector<Trial>* done) {
  if (std::any_of(cameras.begin(), cameras.end(), [](const Split& camera) {
        return !camera.test.images.empty();
      }))
    return TestCameras(adjusted, pattern, cameras, options.rigid_targets,
                       options.num_threads);
  CrossValidate(pattern, options, {knot_spacings_px}, folds, done);
  return JoinFolds(*done, folds->count(), knot_spacings_px,
                   options.rigid_boards, !options.rigid_targets.empty());
}

HeldOutResiduals JoinFolds(const std::vector<Trial>& done, int num_folds,
                           const std::vector<double>& knot_spacings_px,
                           bool rigid_boards, bool has_rigid_targets) {
  const auto append = [](const std::vector<std::vector<FeatureResidual>>& from,
                         std::vector<std::vector<FeatureResidual>>* to) {
    to->resize(std::max(to->size(), from.size()));
    for (size_t c = 0; c < from.size(); ++c)
      (*to)[c].insert((*to)[c].end(), from[c].begin(), from[c].end());
  };
  HeldOutResiduals joined;
  for (int fold = 0; fold < num_folds; ++fold) {
    const Trial* trial = FindTrial(done, fold, knot_spacings_px, rigid_boards,
                                   has_rigid_targets);
    if (!trial) return {};
    append(trial->held_out.alone, &joined.alone);
    append(trial->held_out.together, &joined.together);
    append(trial->held_out.with_deformation, &joined.with_deformation);
  }
  return joined;
}

}  // namespace raygrid
