#include "calibration/calibration.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/base_model.h"
#include "calibration/budget_input.h"
#include "calibration/camera_in_progress.h"
#include "calibration/camera_initialization.h"
#include "calibration/camera_result.h"
#include "calibration/deformation_selection.h"
#include "calibration/divergence.h"
#include "calibration/frame_adjustment.h"
#include "calibration/input_checks.h"
#include "calibration/knot_spacing_selection.h"
#include "calibration/mixed_cameras.h"
#include "calibration/model_based_refinement.h"
#include "calibration/model_selection.h"
#include "calibration/near_duplicates.h"
#include "calibration/parametric_comparison.h"
#include "calibration/restart.h"
#include "calibration/rig_evaluation.h"
#include "calibration/rig_initialization.h"
#include "calibration/rig_uncertainty.h"
#include "calibration/rigid_target_search.h"
#include "calibration/rolling_shutter.h"
#include "calibration/stopwatch.h"
#include "camera/lens_models.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

// Name of a stage, and the range of total progress that it covers.
struct Stage {
  const char* name;
  double begin, end;
};

// Whether there are enough images for each camera without near-duplicates and
// held-out images.
bool HasEnoughViews(const std::vector<Dataset>& cameras,
                    const std::vector<NearDuplicates>& groups,
                    const std::vector<std::string>& held_out) {
  return std::all_of(
      cameras.begin(), cameras.end(), [&](const Dataset& dataset) {
        const Dataset views =
            SplitImages("", RemoveDuplicates(dataset, groups), held_out)
                .training;
        return std::count_if(views.images.begin(), views.images.end(),
                             [](const ImageFeatures& image) {
                               return image.features.size() >= kMinViewFeatures;
                             }) >= kMinImages;
      });
}

// In-plane RMS distance of a board's estimated points from the pattern, after
// the best similarity transform.
double MovedM(const Board& given, const Board& found) {
  const auto count = static_cast<Eigen::Index>(given.points.size());
  if (count < 3 || found.points.size() != given.points.size()) return 0;
  Eigen::Matrix3Xd from(3, count), to(3, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    from.col(k) = given.points[k];
    to.col(k) = found.points[k];
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(from, to, true);
  const Eigen::Vector3d normal =
      similarity.topLeftCorner<3, 3>().col(2).normalized();
  const Eigen::Matrix3Xd moves =
      to - (similarity * from.colwise().homogeneous()).topRows<3>();
  return (moves - normal * (normal.transpose() * moves)).norm() /
         std::sqrt(static_cast<double>(count));
}

// Warns of boards whose estimated points are far from the pattern: no printer
// is as inaccurate, and the prior keeps estimates near the pattern.
void WarnAboutTargetGeometry(const Pattern& given, const Pattern& found,
                             Assessment* assessment) {
  constexpr double kMostPart = 0.01;  // of a square
  for (size_t b = 0; b < given.boards.size(); ++b) {
    const Board& board = given.boards[b];
    const double moved_m = MovedM(board, found.boards[b]);
    if (!(moved_m > kMostPart * board.square_m) || board.IsPointSet()) continue;
    if (assessment->word == "pass") assessment->word = "warn";
    assessment->reasons.push_back(fmt::format(
        "the estimated points of board {} deviate from the pattern by {:.2g} "
        "mm RMS, {:.2g} % of a square: the print is stretched, or the pattern "
        "describes another board, which biases the camera; measure the print "
        "in both directions, and correct the pattern",
        board.id, 1e3 * moved_m, 100 * moved_m / board.square_m));
  }
}

// The steps of a calibration, in this order, each for all cameras.
class Calibration {
 public:
  Calibration(const std::vector<CalibrationInput>& inputs,
              const Pattern& pattern, const CalibrationOptions& options);

  // A parametric model for each camera, from its own images.
  void Start();

  // Features refined with that model, and a new initialization from them.
  void RefineFeaturesCallback();

  // Consistent rotations of rotationally symmetric boards.
  void RotateBoards();

  void CompensateRollingShutter();
  void CompensateRollingShutter(CameraInProgress* camera) const;

  // The knot spacing of each camera's grid.
  void ChooseGrids();

  // Joint adjustment of all cameras, their poses and the boards.
  void OptimizeCameras();

  // Held-out errors. A camera that is worse than the cameras of the folds is
  // adjusted again, initialized from these.
  void EvaluateHeldOutImages();
  void RestartFromFolds();

  void EstimateLineDelays();

  // Comparison with other models.
  void CompareWithOthers();

  // Assessment; the result is handed over.
  RigResult Assess();

 private:
  bool IsRig() const { return cameras_.size() > 1; }
  void Report(const std::string& stage, double done) const {
    if (options_.progress) options_.progress(stage, done);
  }
  void DetectNearDuplicates();
  void StartFromImages(CameraInProgress* camera) const;
  void RotateBoards(const BoardRotations& turns,
                    CameraInProgress* camera) const;
  void RotateBoardsAcrossCameras();
  void RotateBoardsByGeometry();
  void NameDoubtfulTurns(
      const std::vector<std::pair<std::string, int>>& doubtful);
  void FillResults();
  void RestartFromComparison();
  void LookForTwoCameras();
  void CompareModels();
  void ReportUncertainty(CameraInProgress* camera, int num_threads) const;
  void SplitResiduals();
  void ReportFlatBoards();
  void LocalizeDuplicates();
  std::vector<Split> Splits() const;
  std::vector<const CameraModel*> StartingLenses() const;
  std::vector<double> CellsPx() const;
  // In a rig, boards deform if they do so for most cameras.
  bool DoBoardsBend() const;
  bool AreLineDelaysRequested() const;
  // Boards of rigid targets are not deformed: they have no own pose.
  bool AreBoardsRigid() const { return !bodies_.empty() || !DoBoardsBend(); }
  AdjustmentResult AdjustTogether(
      const std::vector<int>& cameras,
      std::vector<std::vector<RejectedImage>>* rejected);
  // Detects rigid multi-board targets, and adjusts with them.
  void OptimizeWithRigidTargets(
      std::vector<std::vector<RejectedImage>>* rejected);

  // Runs a step for one camera after the other, with its progress. In a rig,
  // progress and errors name the camera.
  template <typename Step>
  void ForEachCamera(const Stage& stage, const Step& step) {
    const auto count = static_cast<double>(cameras_.size());
    for (size_t c = 0; c < cameras_.size(); ++c) {
      const std::string& name = cameras_[c].input->name;
      const auto report = [&](double done) {
        Report(IsRig() ? name + ": " + stage.name : stage.name,
               stage.begin + (stage.end - stage.begin) *
                                 (static_cast<double>(c) + done) / count);
      };
      report(0);
      try {
        step(&cameras_[c], report);
      } catch (const Error& error) {
        if (!IsRig()) throw;
        throw Error(error.code(),
                    fmt::format("camera {}: {}", name, error.what()));
      }
    }
  }

  const Pattern& pattern_;
  CalibrationOptions options_;
  bool is_model_auto_;
  std::vector<CameraInProgress> cameras_;
  std::vector<ModelTrials> model_trials_;  // of each camera
  RigidTargets bodies_;
  AdjustmentResult adjusted_;                         // all cameras together
  std::vector<std::vector<RejectedImage>> rejected_;  // by the rig's start
  RigResult result_;
};

Calibration::Calibration(const std::vector<CalibrationInput>& inputs,
                         const Pattern& pattern,
                         const CalibrationOptions& options)
    : pattern_(pattern),
      options_(options),
      is_model_auto_(options.model == kAutoModel),
      model_trials_(inputs.size()) {
  if (is_model_auto_) options_.model = models::kCentralGeneric;
  is_model_auto_ &= options.knot_spacing_px == 0 && !options.like;
  for (const CalibrationInput& input : inputs) {
    CameraInProgress& camera = cameras_.emplace_back();
    camera.input = &input;
    if (input.resume) camera.checkpoint = *input.resume;
    camera.result.camera.name = input.name;
  }
  DetectNearDuplicates();
}

// Near-duplicates of training images are predicted well by any camera, so that
// they count as one image from here on. If too few images remain, all are kept,
// since the assessment then reports that they are similar.
void Calibration::DetectNearDuplicates() {
  std::vector<Dataset> datasets;
  for (const CameraInProgress& camera : cameras_)
    datasets.push_back(camera.input->dataset);
  std::vector<NearDuplicates> groups =
      FindNearDuplicates(datasets, options_.hold_out, options_.duplicate_px);
  std::vector<std::string> copies =
      FindHeldOutDuplicates(datasets, options_.hold_out, options_.duplicate_px);
  if (!HasEnoughViews(datasets, groups, options_.hold_out)) {
    groups.clear();
    copies.clear();
  }
  const auto has_image = [](const Dataset& dataset, const std::string& name) {
    return std::any_of(
        dataset.images.begin(), dataset.images.end(),
        [&name](const ImageFeatures& image) { return image.image == name; });
  };
  for (CameraInProgress& camera : cameras_) {
    const Dataset& given = camera.input->dataset;
    camera.dataset = RemoveDuplicates(given, groups);
    camera.split =
        SplitImages(camera.input->name, camera.dataset, options_.hold_out);
    camera.result.near_duplicates = FilterGroups(given, groups);
    for (const std::string& copy : copies)
      if (has_image(given, copy))
        camera.result.held_out_duplicates.push_back(copy);
  }
}

std::vector<Split> Calibration::Splits() const {
  std::vector<Split> splits;
  for (const CameraInProgress& camera : cameras_)
    splits.push_back(camera.split);
  return splits;
}

std::vector<const CameraModel*> Calibration::StartingLenses() const {
  std::vector<const CameraModel*> lenses;
  for (const CameraInProgress& camera : cameras_)
    lenses.push_back(&camera.lens.state.camera());
  return lenses;
}

std::vector<double> Calibration::CellsPx() const {
  std::vector<double> knot_spacings_px;
  for (const CameraInProgress& camera : cameras_)
    knot_spacings_px.push_back(camera.result.knot_spacing_px);
  return knot_spacings_px;
}

bool Calibration::DoBoardsBend() const {
  const auto count = std::count_if(
      cameras_.begin(), cameras_.end(),
      [](const auto& camera) { return camera.per_view_deformation; });
  return 2 * static_cast<size_t>(count) > cameras_.size();
}

// ---- Initialization --------------------------------------------------------

void Calibration::StartFromImages(CameraInProgress* camera) const {
  // The camera from before the refinement of features, if any.
  const auto& known = camera->lens.state.cameras;
  const std::string base_model = camera->lens.problem.base_model;
  try {
    camera->lens = InitializeCamera(
        camera->split.training, pattern_, MakeAdjustmentOptions(options_),
        options_.area, known.empty() ? nullptr : known.front().get());
    camera->lens.problem.base_model = base_model;
    camera->lens.problem.like = options_.like;
    camera->lens.problem.prior_spread = options_.prior_spread;
  } catch (const Error& error) {
    const size_t num_others = CountDuplicates(camera->result.near_duplicates);
    if (error.code() != ExitCode::kTooFew || num_others == 0) throw;
    throw Error(error.code(),
                fmt::format("{}; {} more are near-duplicate views: move and "
                            "tilt the target between images",
                            error.what(), num_others));
  }
}

void Calibration::Start() {
  const Stopwatch stopwatch(&result_.seconds["start"]);
  ForEachCamera(
      {"initialization", 0, 0.05}, [&](CameraInProgress* camera, auto) {
        StartFromImages(camera);
        if (!IsParametricModel(options_.model))
          camera->lens.problem.base_model =
              ChooseBaseModel(MakeAdjustmentOptions(options_), camera->lens);
        if (!options_.allow_large_distance)
          RequirePlausibleDistances(camera->lens);
      });
}

// ---- Feature refinement ----------------------------------------------------

void Calibration::RefineFeaturesCallback() {
  if (std::none_of(cameras_.begin(), cameras_.end(), [](const auto& camera) {
        return camera.input->refine_features != nullptr;
      }))
    return;
  const Stopwatch stopwatch(&result_.seconds["measuring_again"]);
  ForEachCamera({"refining features", 0.05, 0.1}, [&](CameraInProgress* camera,
                                                      auto) {
    if (!camera->input->refine_features || options_.ShouldStop()) return;
    std::optional<Dataset>& again = camera->checkpoint.refined_features;
    if (!again) again = RefineFeaturesWithModel(pattern_, options_, *camera);
    if (!again) return;
    camera->Save();
    camera->result.refinement_rms_px =
        ComputeRmsShiftPx(camera->dataset, *again);
    camera->split = SplitImages(camera->input->name, *again, options_.hold_out);
    StartFromImages(camera);
  });
}

// ---- Board rotations -------------------------------------------------------

// Adds rotations to a camera's, and initializes it again.
void Calibration::RotateBoards(const BoardRotations& turns,
                               CameraInProgress* camera) const {
  BoardRotations own;  // of images that this camera has
  for (const ImageFeatures& image : camera->input->dataset.images)
    for (const Board& board : pattern_.boards)
      if (const auto found = turns.find({image.image, board.id});
          found != turns.end())
        own.insert(*found);
  if (own.empty()) return;
  camera->turns = ComposeRotations(camera->turns, own, pattern_);
  camera->dataset = Rotated(camera->dataset, pattern_, own);
  camera->split.training = Rotated(camera->split.training, pattern_, own);
  camera->split.test = Rotated(camera->split.test, pattern_, own);
  StartFromImages(camera);
}

void Calibration::RotateBoardsAcrossCameras() {
  std::vector<AdjustmentResult> cameras;
  for (const CameraInProgress& camera : cameras_)
    cameras.push_back(LocalizeDatasetViews(camera.lens.state.camera(),
                                           CollectFeatures(camera, pattern_),
                                           pattern_, options_.num_threads));
  RigRotations found =
      ResolveRotationsAcrossCameras(cameras, pattern_, options_.num_threads);
  for (size_t c = 0; c < cameras_.size(); ++c)
    RotateBoards(found.by_camera[c], &cameras_[c]);
  result_.ambiguous_pairs = std::move(found.ambiguous);
}

// Nominal points are invariant to a rotation; only estimated ones reveal it.
void Calibration::RotateBoardsByGeometry() {
  CalibrationOptions nominal = options_;
  nominal.fix_target_geometry = true;
  std::vector<AdjustmentResult> cameras;
  for (const CameraInProgress& camera : cameras_) {
    const FirstCamera first = EstimateFirstCamera(pattern_, nominal, camera);
    if (options_.ShouldStop()) return;
    cameras.push_back(first.adjusted);
    AddViews(
        LocalizeDatasetViews(first.adjusted.state.camera(), camera.split.test,
                             pattern_, options_.num_threads),
        &cameras.back());
  }
  const auto [turns, doubtful] = ResolveRotationsByGeometry(cameras, pattern_);
  NameDoubtfulTurns(doubtful);
  if (turns.empty()) return;
  // Errors of the model may resemble board errors: estimated points decide.
  struct AsBefore {
    BoardRotations turns;
    Dataset dataset;
    Split split;
    AdjustmentResult lens;
  };
  constexpr double kBetter = 0.98;
  std::vector<AsBefore> as_before;
  double before_px = 0, after_px = 0;
  const auto error_px = [this](const CameraInProgress& camera,
                               const AdjustmentResult& start) {
    return ComputeMeanErrorPx(
        EstimateFirstCamera(pattern_, options_, camera).adjusted, start);
  };
  for (CameraInProgress& camera : cameras_) {
    before_px += error_px(camera, camera.lens);
    as_before.push_back(
        {camera.turns, camera.dataset, camera.split, camera.lens});
    RotateBoards(turns, &camera);
    after_px += error_px(camera, as_before.back().lens);
  }
  if (after_px < kBetter * before_px && !options_.ShouldStop()) return;
  for (size_t c = 0; c < cameras_.size(); ++c) {
    cameras_[c].turns = std::move(as_before[c].turns);
    cameras_[c].dataset = std::move(as_before[c].dataset);
    cameras_[c].split = std::move(as_before[c].split);
    cameras_[c].lens = std::move(as_before[c].lens);
    cameras_[c].result.ambiguous_rotation_images.clear();
  }
}

void Calibration::NameDoubtfulTurns(
    const std::vector<std::pair<std::string, int>>& doubtful) {
  for (CameraInProgress& camera : cameras_)
    for (const ImageFeatures& image : camera.dataset.images)
      if (std::any_of(doubtful.begin(), doubtful.end(), [&](const auto& view) {
            return view.first == image.image;
          }))
        camera.result.ambiguous_rotation_images.push_back(image.image);
}

void Calibration::RotateBoards() {
  if (!HasSymmetricBoards(pattern_) || options_.ShouldStop()) return;
  const Stopwatch stopwatch(&result_.seconds["start"]);
  if (IsRig()) RotateBoardsAcrossCameras();
  if (!options_.fix_target_geometry) RotateBoardsByGeometry();
}

// ---- Rolling shutter -------------------------------------------------------

bool Calibration::AreLineDelaysRequested() const {
  return std::any_of(cameras_.begin(), cameras_.end(), [](const auto& camera) {
    return camera.input->times.has_value();
  });
}

// A first camera and its board partly absorb the motion, and reduce the line
// delay. It is estimated again from features without most of the motion.
void Calibration::CompensateRollingShutter(CameraInProgress* camera) const {
  constexpr int kMaxRounds = 6;
  double before_s = 0;
  for (int round = 0; round < kMaxRounds; ++round) {
    auto still = ComputeCompensatedFeatures(pattern_, options_, *camera);
    if (!still) return;
    camera->still = std::move(still->features);
    camera->split = SplitImages(
        camera->input->name,
        RemoveDuplicates(*camera->still, camera->result.near_duplicates),
        options_.hold_out);
    StartFromImages(camera);
    const LineDelay& now = still->line_delay;
    if (std::abs(now.seconds - before_s) < now.deviation_s / 2) return;
    before_s = now.seconds;
  }
}

void Calibration::CompensateRollingShutter() {
  if (!AreLineDelaysRequested()) return;
  const Stopwatch stopwatch(&result_.seconds["row_time"]);
  ForEachCamera({"line delay", 0.1, 0.12}, [&](CameraInProgress* camera, auto) {
    if (!camera->input->times || options_.ShouldStop()) return;
    CompensateRollingShutter(camera);
  });
}

void Calibration::EstimateLineDelays() {
  if (!AreLineDelaysRequested()) return;
  const Stopwatch stopwatch(&result_.seconds["row_time"]);
  for (CameraInProgress& camera : cameras_) {
    if (!camera.input->times || options_.ShouldStop()) continue;
    CalibrationResult& result = camera.result;
    result.line_delay = EstimateFinalLineDelay(
        camera, *result.camera.camera, result_.pattern, options_.num_threads);
    if (result.line_delay->IsDetermined())
      result.camera.line_delay = result.line_delay->value;
  }
}

// ---- Knot spacing ----------------------------------------------------------

void Calibration::ChooseGrids() {
  const Stopwatch stopwatch(&result_.seconds["cross_validation"]);
  ForEachCamera({"cross-validation", 0.1, 0.6}, [&](CameraInProgress* camera,
                                                    const auto& report) {
    camera->folds = MakeFolds({camera->split}, {&camera->lens.state.camera()});
    camera->folds.base_model = camera->lens.problem.base_model;
    SelectKnotSpacing(pattern_, options_, report, camera);
    SelectDeformation(pattern_, options_, camera);
    for (Folds::Fold& fold : camera->folds.folds) fold.rigid.clear();
  });
  if (!is_model_auto_ || options_.ShouldStop()) return;
  ModelSelection selection =
      raygrid::SelectModel(pattern_, options_, &cameras_);
  options_.model = selection.model;
  model_trials_ = std::move(selection.trials);
  for (CameraInProgress& camera : cameras_) {
    camera.grid_knot_spacing_px = camera.result.knot_spacing_px;
    if (IsParametricModel(options_.model)) {
      camera.result.knot_spacing_px = 0;
      camera.per_view_deformation = false;
    } else if (options_.model == models::kNonCentralGeneric) {
      camera.result.knot_spacing_px =
          std::max(camera.grid_knot_spacing_px,
                   MediumKnotSpacingPx(camera.split.training, options_.model));
    }
  }
}

// ---- Adjustment ------------------------------------------------------------

AdjustmentResult Calibration::AdjustTogether(
    const std::vector<int>& cameras,
    std::vector<std::vector<RejectedImage>>* rejected) {
  std::vector<std::string> names;
  std::vector<AdjustmentResult> lenses;
  std::vector<double> knot_spacings_px;
  for (const int c : cameras) {
    names.push_back(cameras_[c].input->name);
    lenses.push_back(cameras_[c].lens);
    knot_spacings_px.push_back(cameras_[c].result.knot_spacing_px);
  }
  if (IsRig()) Report("rig initialization", 0.6);
  rejected->clear();
  AdjustmentResult adjusted = InitializeRig(
      names, lenses, bodies_, MakeAdjustmentOptions(options_), rejected);
  Report("bundle adjustment", 0.65);
  AdjustmentOptions adjustment = MakeStoppableOptions(options_);
  adjustment.rigid_boards = AreBoardsRigid();
  OptimizeModel(pattern_, options_.model, knot_spacings_px, adjustment,
                &adjusted);
  OptimizeInCameraFrames(adjustment, &adjusted);
  AlignBoards(pattern_, &adjusted);
  return adjusted;
}

void Calibration::OptimizeWithRigidTargets(
    std::vector<std::vector<RejectedImage>>* rejected) {
  std::vector<AdjustmentResult> lenses;
  std::vector<int> all;
  for (const CameraInProgress& camera : cameras_) {
    all.push_back(static_cast<int>(all.size()));
    lenses.push_back(camera.lens);
  }
  const auto groups = ConnectedGroups(lenses);
  const bool may_tell = !options_.independent_boards &&
                        CanDetectRigidTargets(lenses) &&
                        (groups.size() > 1 || !DoBoardsBend());
  std::vector<AdjustmentResult> apart;
  if (groups.size() == 1 || !may_tell)
    apart.push_back(AdjustTogether(all, rejected));
  else
    for (const std::vector<int>& group : groups)
      apart.push_back(AdjustTogether(group, rejected));
  if (may_tell)
    result_.board_pairs =
        CompareBoardPoses(apart, pattern_, options_.num_threads, &bodies_);
  if (apart.size() == 1 && bodies_.empty()) {
    adjusted_ = std::move(apart.front());
    return;
  }
  try {
    adjusted_ = AdjustTogether(all, rejected);
  } catch (const Error& error) {
    const auto told = DescribeRigidTargets({}, result_.board_pairs);
    if (error.code() != ExitCode::kInitialization || told.empty()) throw;
    throw Error(error.code(),
                fmt::format("{}; {}", error.what(), told.front()));
  }
}

void Calibration::OptimizeCameras() {
  const Stopwatch stopwatch(&result_.seconds["adjustment"]);
  OptimizeWithRigidTargets(&rejected_);
  FillResults();
}

void Calibration::FillResults() {
  result_.rigid_targets.clear();
  for (const std::vector<int>& group : bodies_.Groups()) {
    const RigidTargets found = UpdateRigidTargets(
        bodies_, adjusted_.problem, adjusted_.state.target_from_board);
    RigidTarget& body = result_.rigid_targets.emplace_back();
    for (const int b : group) {
      body.boards.push_back(pattern_.boards[b].id);
      body.first_from_board.push_back(
          found.frame_from_board[group.front()].Inverse() *
          found.frame_from_board[b]);
    }
  }
  AdjustmentOptions adjustment = MakeStoppableOptions(options_);
  adjustment.rigid_boards = AreBoardsRigid();

  for (size_t c = 0; c < cameras_.size(); ++c) {
    CalibrationResult& result = cameras_[c].result;
    result.rejected_images = cameras_[c].lens.rejected_images;
    result.rejected_images.insert(result.rejected_images.end(),
                                  rejected_[c].begin(), rejected_[c].end());
    result.poses.clear();
    FillResult(pattern_, adjusted_, static_cast<int>(c),
               cameras_[c].input->image_circle, options_.num_threads, &result);
  }
  result_.pattern = MakeEstimatedPattern(pattern_, adjusted_);
  result_.pattern.rigid_targets = result_.rigid_targets;
  result_.camera_from_rig = adjusted_.state.camera_from_rig;
  result_.baselines = EstimateBaselines(adjusted_, adjustment);
  result_.converged = adjusted_.summary.converged;
}

// ---- Evaluation ------------------------------------------------------------

void Calibration::EvaluateHeldOutImages() {
  const Stopwatch stopwatch(&result_.seconds["cross_validation"]);
  CameraInProgress& first = cameras_.front();
  // Stored trials belong to a given model.
  const bool is_kept =
      !IsRig() &&
      !(is_model_auto_ && options_.model == models::kNonCentralGeneric);
  std::vector<Trial> not_kept;
  std::vector<Trial>& trials = is_kept ? first.checkpoint.trials : not_kept;
  const ModelTrials& done = model_trials_.front();
  const auto tried = done.find(options_.model);
  if (options_.hold_out.empty() && !IsRig() && tried != done.end() &&
      options_.model != models::kCentralGeneric)
    trials.insert(trials.end(), tried->second.begin(), tried->second.end());
  ValidationOptions validation = MakeValidationOptions(options_);
  validation.rigid_boards = AreBoardsRigid();
  validation.rigid_targets = bodies_;
  validation.progress = [this](double done) {
    Report("cross-validation", 0.7 + 0.15 * done);
  };
  if (!IsRig()) validation.on_done = [&first] { first.Save(); };
  // Folds of single cameras were initialized before rigid targets were known.
  const bool is_anew = IsRig() || !bodies_.empty();
  Folds anew;
  if (is_anew) anew = MakeFolds(Splits(), StartingLenses());
  anew.base_model = adjusted_.problem.base_model;
  HeldOutResiduals held_out =
      EvaluateHeldOut(adjusted_, pattern_, Splits(), validation, CellsPx(),
                      is_anew ? &anew : &first.folds, &trials);
  result_.held_out = std::move(held_out.together);
  result_.cross_validated = options_.hold_out.empty();
  for (size_t c = 0; c < held_out.alone.size(); ++c) {
    cameras_[c].result.held_out = std::move(held_out.alone[c]);
    if (!held_out.flexed[c].empty())
      cameras_[c].result.held_out_deformed =
          ComputeErrorMetrics(held_out.flexed[c]);
    cameras_[c].result.cross_validated = result_.cross_validated;
  }
  // A given knot spacing is listed like the candidates for selection.
  if (!IsRig() && first.result.cross_validated &&
      options_.knot_spacing_px > 0 && first.result.knot_spacing_px > 0)
    first.result.knot_spacing_candidates = {SummarizeCandidate(
        first.result.knot_spacing_px, first.result.held_out)};
}

void Calibration::RestartFromFolds() {
  CameraInProgress& camera = cameras_.front();
  if (IsRig() || !bodies_.empty() || options_.ShouldStop() ||
      !IsWorseThanFolds(camera, adjusted_, AreBoardsRigid(),
                        camera.result.knot_spacing_px))
    return;
  const Stopwatch stopwatch(&result_.seconds["adjustment"]);
  raygrid::RestartFromFolds(
      pattern_, options_, [this] { return AdjustTogether({0}, &rejected_); },
      &camera, &adjusted_);
  FillResults();
  if (!options_.hold_out.empty()) EvaluateHeldOutImages();
}

// A grid has no larger errors than a parametric model, unless it diverged.
void Calibration::RestartFromComparison() {
  CameraInProgress& camera = cameras_.front();
  if (IsRig() || !bodies_.empty() || options_.ShouldStop() ||
      IsParametricModel(options_.model) ||
      !raygrid::RestartFromComparison(pattern_, options_, AreBoardsRigid(),
                                      &camera, &adjusted_))
    return;
  FillResults();
  if (!options_.hold_out.empty()) EvaluateHeldOutImages();
  ReportUncertainty(&camera, options_.num_threads);
}

// Mixed images are detected for single cameras only: a rig's are separate.
void Calibration::LookForTwoCameras() {
  if (IsRig() || options_.ShouldStop()) return;
  const Stopwatch stopwatch(&result_.seconds["two_cameras"]);
  CameraInProgress& camera = cameras_.front();
  if (IsSingleCamera(camera.result)) return;
  camera.result.mixed_cameras =
      DetectMixedCameras(camera.split.training, pattern_, camera.lens,
                         MakeStoppableOptions(options_));
  if (options_.ShouldStop()) camera.result.mixed_cameras.reset();
}

void Calibration::ReportUncertainty(CameraInProgress* camera,
                                    int num_threads) const {
  FillUncertainty(adjusted_, static_cast<int>(camera - cameras_.data()),
                  camera->input->image_circle, options_.valid_px, num_threads,
                  &camera->result);
}

// Estimated concurrently with other models: it hardly needs a second thread.
void Calibration::CompareModels() {
  if (!options_.compare_models || options_.ShouldStop()) {
    const Stopwatch stopwatch(&result_.seconds["uncertainty"]);
    for (CameraInProgress& camera : cameras_)
      ReportUncertainty(&camera, options_.num_threads);
    return;
  }
  const Stopwatch stopwatch(&result_.seconds["comparison"]);
  // The flatness of boards does not depend on the model.
  CalibrationOptions options = options_;
  options.fix_target_geometry =
      options.fix_target_geometry ||
      (!HavePointsMoved(adjusted_) && !adjusted_.state.HasStaticDeformation());
  if (options.fix_target_geometry != options_.fix_target_geometry)
    model_trials_.assign(cameras_.size(), {});
  ForEachCamera({"other models", 0.85, 1}, [&](CameraInProgress* camera, auto) {
    CalibrationResult& result = camera->result;
    const ModelTrials& done = model_trials_[camera - cameras_.data()];
    result.parametric_models = CompareParametricModels(
        *camera, pattern_, options, done,
        [&](int num_threads) { ReportUncertainty(camera, num_threads); });
    if (IsRig() || options.ShouldStop() || !HasSystematicErrors(result)) return;
    if (auto metrics = CompareAlternativeGrid(*camera, pattern_, options, done))
      result.parametric_models.push_back(std::move(*metrics));
  });
  RestartFromComparison();
  for (CameraInProgress& camera : cameras_)
    camera.result.model_error_px = EstimateModelErrorPx(camera.result);
}

void Calibration::CompareWithOthers() {
  LookForTwoCameras();
  CompareModels();
}

// ---- Assessment ------------------------------------------------------------

// Splits the residuals of each camera by cause.
void Calibration::SplitResiduals() {
  const Stopwatch stopwatch(&result_.seconds["residual_budget"]);
  for (CameraInProgress& camera : cameras_)
    camera.result.budget = ComputeResidualBudget(MakeBudgetInput(
        camera.result, MakeBudgetFacts(camera.result, options_)));
}

// Boards in near-duplicates, localized with the cameras.
void Calibration::LocalizeDuplicates() {
  RigModel rig = {{}, result_.camera_from_rig, {}};
  std::vector<Dataset> others;
  bool are_any = false;
  for (size_t c = 0; c < cameras_.size(); ++c) {
    rig.cameras.push_back(result_.cameras[c].camera.camera.get());
    const CameraInProgress& camera = cameras_[c];
    others.push_back(SelectDuplicates(
        camera.still ? *camera.still
                     : Rotated(camera.input->dataset, pattern_, camera.turns),
        result_.cameras[c].near_duplicates));
    are_any |= !others.back().images.empty();
  }
  if (!are_any || options_.ShouldStop()) return;
  const auto poses =
      LocalizeBoards(rig, others, result_.pattern, options_.num_threads);
  for (size_t c = 0; c < cameras_.size(); ++c)
    result_.cameras[c].poses.insert(result_.cameras[c].poses.end(),
                                    poses[c].begin(), poses[c].end());
}

// Estimates the deformation of boards that were assumed flat.
void Calibration::ReportFlatBoards() {
  const double height_m = EstimateFlatnessError(
      pattern_, MakeStoppableOptions(options_), adjusted_);
  for (CameraInProgress& camera : cameras_)
    camera.result.flatness_error_m = height_m;
}

RigResult Calibration::Assess() {
  if (options_.fix_target_geometry && !options_.ShouldStop())
    ReportFlatBoards();
  const bool is_interrupted = options_.ShouldStop();
  if (!is_interrupted) SplitResiduals();
  for (CameraInProgress& camera : cameras_) {
    if (is_interrupted) camera.result.checkpoint = std::move(camera.checkpoint);
    if (!is_interrupted && options_.like && options_.prior_spread)
      FillFleetDistance(*options_.like, *options_.prior_spread, &camera.result);
    ListUnusedImages(camera.dataset, camera.input->skipped, &camera.result);
    ReportExcludedImages(camera, pattern_, &camera.result.rejected_images);
    if (!is_interrupted)
      FindUniqueCoverageImages(adjusted_,
                               static_cast<int>(&camera - cameras_.data()),
                               options_.num_threads, &camera.result);
    AssessResult(options_.num_threads, &camera.result);
    if (!is_interrupted)
      WarnAboutTargetGeometry(pattern_, camera.result.pattern,
                              &camera.result.assessment);
    camera.result.turns = camera.turns;
    result_.cameras.push_back(std::move(camera.result));
  }
  result_.assessment = AssessRig(result_);
  LocalizeDuplicates();
  Report("done", 1);
  return std::move(result_);
}

}  // namespace

std::vector<std::string> CalibratedModels() {
  std::vector<std::string> names =
      LensNames(ModelUse::kCalibrate,
                {models::kNonCentralGeneric, models::kCentralGeneric});
  std::reverse(names.begin(), names.end());
  return names;
}

RigResult Calibrate(const std::vector<CalibrationInput>& cameras,
                    const Pattern& pattern, const CalibrationOptions& options) {
  RequireValidInput(cameras, pattern, options);
  Calibration calibration(cameras, pattern, options);
  calibration.Start();
  calibration.RefineFeaturesCallback();
  calibration.RotateBoards();
  calibration.CompensateRollingShutter();
  calibration.ChooseGrids();
  calibration.OptimizeCameras();
  calibration.EvaluateHeldOutImages();
  calibration.RestartFromFolds();
  calibration.EstimateLineDelays();
  calibration.CompareWithOthers();
  return calibration.Assess();
}

CalibrationResult Calibrate(const Dataset& dataset, const Pattern& pattern,
                            const CalibrationOptions& options) {
  return std::move(Calibrate({CalibrationInput{"", dataset}}, pattern, options)
                       .cameras.front());
}

}  // namespace raygrid
