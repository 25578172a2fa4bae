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
#include "camera/lens_spread.h"
#include "dataset/dataset.h"
#include "evaluation/checkpoint.h"

namespace raygrid {

/// A camera's images to calibrate with, and those to test with.
struct Split {
  std::string camera;  ///< its name in a rig
  Dataset training, test;
};
Split SplitImages(const std::string& camera, const Dataset& dataset,
                  const std::vector<std::string>& test_images);

/// The part of the images that each camera is calibrated with.
constexpr double kTrainingShare = 0.75;

/// The folds of a cross-validation, of the training images of one camera or of
/// a rig: four, one for many images, which take long and need no more, or none
/// for few.
struct Folds {
  /// One of them, and what trials in it have in common: found once, kept for
  /// those to come.
  struct Fold {
    std::vector<Split> cameras;
    std::optional<AdjustmentResult> start;   ///< with starting lenses
    std::optional<AdjustmentResult> lenses;  ///< those that grids lie around
    std::vector<std::pair<std::vector<double>, AdjustmentResult>>
        rigid;  ///< by cells
  };
  std::vector<Fold> folds;
  /// Starting lenses of all training images, which each fold adjusts to its
  /// own.
  std::vector<std::shared_ptr<const CameraModel>> known;
  /// CalibrationProblem::base_model, found with all training images.
  std::string base_model;
  /// Knot spacings of one camera's central grid, each of which but the first
  /// starts from the one before it, in every fold.
  std::vector<double> ladder_px;

  int count() const { return static_cast<int>(folds.size()); }
};
/// known are lenses of all training images of each camera.
Folds MakeFolds(const std::vector<Split>& cameras,
                const std::vector<const CameraModel*>& known);
/// A fold for each view, of fewer views than MakeFolds() has folds for; none
/// for fewer than four.
Folds MakeLeaveOneOutFolds(const std::vector<Split>& cameras,
                           const std::vector<const CameraModel*>& known);

struct ValidationOptions {
  std::string model;
  AreaChoice area = AreaChoice::kWholeImage;
  /// Those of CalibrationOptions.
  std::shared_ptr<const CameraModel> like = {};
  std::shared_ptr<const LensSpread> prior_spread = {};
  bool fix_target_geometry = false;
  bool rigid_boards = true;  ///< in calibrating
  /// Whether to keep what is adjusted with rigid boards, for trials of the same
  /// model with boards that bend.
  bool keep_rigid = false;
  int num_folds = 0;  ///< the first ones; 0: all
  RigidTargets rigid_targets;
  int num_threads = 0;
  std::function<void(double)> progress;
  std::function<bool()> should_stop;
  /// Called when *done has grown, by one thread at a time.
  std::function<void()> on_done;
};

/// Candidates, the cells of each camera, in every fold of the training images,
/// in parallel: the images whose turn it is are localised with cameras
/// calibrated without them. Leaves out what is in *done already, and adds to
/// it; some is missing after a stop. Only the model and whether boards are
/// rigid may change between calls with one *folds.
void CrossValidate(const Pattern& pattern, const ValidationOptions& options,
                   const std::vector<std::vector<double>>& candidates,
                   Folds* folds, std::vector<Trial>* done);

/// Tests adjusted cameras with their test images or, where no camera has any,
/// cells by cross-validation, with what is done of it.
HeldOutResiduals EvaluateHeldOut(const AdjustmentResult& adjusted,
                                 const Pattern& pattern,
                                 const std::vector<Split>& cameras,
                                 const ValidationOptions& options,
                                 const std::vector<double>& knot_spacings_px,
                                 Folds* folds, std::vector<Trial>* done);

/// The residuals over all folds of one candidate; nothing if a fold is missing.
HeldOutResiduals JoinFolds(const std::vector<Trial>& done, int num_folds,
                           const std::vector<double>& knot_spacings_px,
                           bool rigid_boards, bool has_rigid_targets = false);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CROSS_VALIDATION_H
