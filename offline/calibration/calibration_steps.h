#ifndef RAYGRID_CALIBRATION_CALIBRATION_STEPS_H
#define RAYGRID_CALIBRATION_CALIBRATION_STEPS_H

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "calibration/camera_in_progress.h"
#include "calibration/model_selection.h"
#include "calibration/rigid_targets.h"
#include "dataset/error.h"

namespace raygrid {

/// The steps of a calibration. They run in the order of declaration, each for
/// all cameras.
class Calibration {
 public:
  Calibration(const std::vector<CalibrationInput>& inputs,
              const Pattern& pattern, const CalibrationOptions& options);

  /// Initializes a parametric model for each camera from the images of this
  /// camera.
  void Start();

  /// Refines the features with that model and initializes again from them.
  void RefineFeatures();

  /// Determines consistent rotations of rotationally symmetric boards.
  void RotateBoards();

  void CompensateRollingShutter();
  void CompensateRollingShutter(CameraInProgress* camera) const;

  /// Selects the knot spacing of each camera's grid.
  void SelectKnotSpacings();

  /// Optimizes all cameras, their poses and the boards jointly.
  void OptimizeCameras();

  /// Computes the held-out errors. A camera that is worse than the cameras of
  /// the folds is then adjusted again, initialized from these.
  void EvaluateHeldOutImages();
  void RestartFromFolds();

  void EstimateLineDelays();

  /// Compares the cameras with those of other models.
  void CompareWithOthers();

  /// Assesses the result and moves it to the caller.
  RigResult Assess();

 private:
  // Name of a stage, and the range of total progress that it covers.
  struct Stage {
    const char* name;
    double begin, end;
  };

  bool IsRig() const { return cameras_.size() > 1; }
  void Report(const std::string& stage, double done) const {
    if (options_.progress) options_.progress(stage, done);
  }
  void DetectNearDuplicates();
  void InitializeFromImages(CameraInProgress* camera) const;
  void RotateBoards(const BoardRotations& turns,
                    CameraInProgress* camera) const;
  void RotateBoardsAcrossCameras();
  void RotateBoardsByGeometry();
  void WarnAboutAmbiguousRotations(
      const std::vector<std::pair<std::string, int>>& doubtful);
  void FillResults();
  void RestartFromComparison();
  void CheckForTransformedImages();
  void CheckForMixedCameras();
  void CompareModels();
  void ReportUncertainty(CameraInProgress* camera, int num_threads) const;
  void SplitResiduals();
  void ReportFlatBoards();
  void LocalizeDuplicates();
  std::vector<Split> GetSplits() const;
  std::vector<const CameraModel*> GetInitialCameras() const;
  std::vector<double> KnotSpacingsPx() const;
  // Returns whether per-view deformation is estimated; in a rig, if most
  // cameras require it.
  bool DoBoardsDeform() const;
  bool AreLineDelaysRequested() const;
  // Returns whether boards are rigid. The boards of rigid targets are, because
  // deformation needs a separate pose for each board.
  bool AreBoardsRigid() const { return !bodies_.empty() || !DoBoardsDeform(); }
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
  bool selects_model_;
  std::vector<CameraInProgress> cameras_;
  std::vector<ModelTrials> model_trials_;  // one per camera
  bool do_trials_fix_target_ = false;
  RigidTargets bodies_;
  AdjustmentResult adjusted_;                         // joint result of all
                                                      // cameras
  std::vector<std::vector<RejectedImage>> rejected_;  // rejected when the rig
                                                      // was initialized
  RigResult result_;
};

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CALIBRATION_STEPS_H
