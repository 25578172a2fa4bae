#ifndef RAYGRID_CALIBRATION_CROSS_VALIDATION_H
#define RAYGRID_CALIBRATION_CROSS_VALIDATION_H

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calibration/model_adjustment.h"
#include "calibration/rigid_targets.h"
#include "camera/population_covariance.h"
#include "dataset/dataset.h"
#include "evaluation/checkpoint.h"

namespace raygrid {

/// Training and test images of a camera.
struct Split {
  std::string camera;  ///< camera name in a rig
  Dataset training, test;
};
Split SplitImages(const std::string& camera, const Dataset& dataset,
                  const std::vector<std::string>& test_images);

/// Fraction of the images used to calibrate in each fold.
constexpr double kTrainingFraction = 0.75;

/// Folds of a cross-validation over the training images of a camera or rig:
/// four, one if there are many images, where calibration is slow and one
/// suffices, or none if there are few.
struct Folds {
  /// A fold, with intermediate results that all its trials share; they are
  /// computed once.
  struct Fold {
    std::vector<Split> cameras;
    std::optional<AdjustmentResult> start;   ///< initial cameras
    std::optional<AdjustmentResult> lenses;  ///< base models of the grids
    std::vector<std::pair<std::vector<double>, AdjustmentResult>>
        rigid;  ///< results by knot spacings
  };
  std::vector<Fold> folds;
  /// Initial cameras of all training images, optimized in each fold.
  std::vector<std::shared_ptr<const CameraModel>> known;
  /// CalibrationProblem::base_model, chosen with all training images.
  std::string base_model;
  /// Knot spacings of a single camera's central grid, and the index of the
  /// medium one. In each fold, every other grid is initialized from its
  /// neighbour in the direction of the medium one.
  std::vector<double> knot_spacing_levels_px;
  int medium_level = 0;

  /// A single camera's initialization with all training images, or null.
  std::shared_ptr<const AdjustmentResult> whole;
  /// Results of OptimizeWhole() with free or fixed points.
  struct WholeResult {
    std::string model;
    double knot_spacing_px;
    bool fix_points;
    AdjustmentResult adjusted;
  };
  std::vector<std::shared_ptr<const WholeResult>> whole_results;

  int count() const { return static_cast<int>(folds.size()); }
};

/// Optimizes a single camera with rigid boards and all training images,
/// starting from Folds::whole: the steps of OptimizeModel() before board
/// deformation and FinalizeCameras(). Results are computed once.
const AdjustmentResult& OptimizeWhole(const Pattern& pattern,
                                      const std::string& model,
                                      double knot_spacing_px,
                                      const AdjustmentOptions& options,
                                      Folds* folds);
/// Makes the folds. known: initial cameras estimated from all training images,
/// one per camera.
Folds MakeFolds(const std::vector<Split>& cameras,
                const std::vector<const CameraModel*>& known);
/// Returns one fold per view, for datasets with too few views for MakeFolds();
/// no folds for fewer than four views.
Folds MakeLeaveOneOutFolds(const std::vector<Split>& cameras,
                           const std::vector<const CameraModel*>& known);

/// OptimizeModel() for a single camera, based on OptimizeWhole().
AdjustmentResult OptimizeWholeModel(const Pattern& pattern,
                                    const std::string& model,
                                    double knot_spacing_px,
                                    const AdjustmentOptions& options,
                                    Folds* folds);

struct ValidationOptions {
  std::string model;
  AreaChoice area = AreaChoice::kWholeImage;
  /// As in CalibrationOptions.
  std::shared_ptr<const CameraModel> like = {};
  std::shared_ptr<const PopulationCovariance> prior_population = {};
  bool fix_target_geometry = false;
  bool rigid_boards = true;  ///< during calibration
  /// Keeps the results with rigid boards, for trials of the same model with
  /// board deformation.
  bool keep_rigid = false;
  int num_folds = 0;  ///< uses the first folds only; 0: all
  RigidTargets rigid_targets;
  int num_threads = 0;
  std::function<void(double)> progress;
  std::function<bool()> should_stop;
  /// Called after trials were appended to *done, by one thread at a time.
  std::function<void()> on_done;
};

/// Initializes the folds that CrossValidate() with these options has not.
void InitializeFolds(const Pattern& pattern, const ValidationOptions& options,
                     Folds* folds);

/// Evaluates candidates (knot spacings by camera) in every fold, in parallel:
/// the held-out images are localized with cameras calibrated without them.
/// Skips trials that are already in *done and appends new ones; after a stop
/// some are missing. Between calls with the same *folds, only the model and
/// rigid_boards may change.
void CrossValidate(const Pattern& pattern, const ValidationOptions& options,
                   const std::vector<std::vector<double>>& candidates,
                   Folds* folds, std::vector<Trial>* done);

/// Evaluates adjusted cameras with their test images or, if no camera has any,
/// their knot spacings by cross-validation, reusing trials in *done.
HeldOutResiduals EvaluateHeldOut(const AdjustmentResult& adjusted,
                                 const Pattern& pattern,
                                 const std::vector<Split>& cameras,
                                 const ValidationOptions& options,
                                 const std::vector<double>& knot_spacings_px,
                                 Folds* folds, std::vector<Trial>* done);

/// Joins a candidate's residuals of all folds; empty if a fold is missing.
HeldOutResiduals JoinFolds(const std::vector<Trial>& done, int num_folds,
                           const std::vector<double>& knot_spacings_px,
                           bool rigid_boards, bool has_rigid_targets = false);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CROSS_VALIDATION_H
