#ifndef RAYGRID_EVALUATION_CALIBRATION_RESULT_H
#define RAYGRID_EVALUATION_CALIBRATION_RESULT_H

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dataset/camera_file.h"
#include "dataset/dataset.h"
#include "evaluation/checkpoint.h"
#include "evaluation/fleet_distance.h"
#include "evaluation/fold_over.h"
#include "evaluation/line_spread.h"
#include "evaluation/residual_budget.h"
#include "evaluation/residual_statistics.h"
#include "evaluation/uncertainty_summary.h"
#include "evaluation/verdict.h"

namespace raygrid {

/// An image that was not used.
struct RejectedImage {
  std::string image, reason;
  bool has_too_few_features = false;
};

/// Images that show the view of one that stands for them.
struct SameViews {
  std::string image;
  std::vector<std::string> others;
};

/// How far boards were bent from their mean shape, view by view.
struct BoardBends {
  struct View {
    std::string image;
    int board = 0;
    double rms_m = 0;  ///< of the points' heights over the mean shape
  };
  std::vector<View> views;
  double rms_m = 0;  ///< of all views
  /// Of the view that is bent most: its index, and the height of each point.
  int most_bent = 0;
  std::vector<double> heights_m;
};

/// A grid resolution that was tried, and its held-out error.
struct CellCandidate {
  double cell_px = 0;
  double loss = 0;  ///< mean Huber loss, px^2
  double median_px = 0;
};

/// A model that was tried, and its error in cross-validation.
struct ModelCandidate {
  std::string model;
  double loss = 0;  ///< mean Huber loss, px^2
  double median_px = 0;
  double gain = 0;  ///< over the grid, in standard errors of the difference
};

/// Another model, adjusted to the same features, and tested with the same ones.
struct ModelFigures {
  std::string model;
  int num_parameters = 0;
  ErrorFigures training;
  std::optional<ErrorFigures> held_out, held_out_flexed;
  std::optional<double> bias_kl;
  std::vector<FeatureResidual> held_out_residuals;  ///< not kept in files
};

/// The result of calibrating one camera, alone or in a rig.
struct CalibrationResult {
  CameraFile camera;
  Pattern pattern;   ///< points where they were found to be
  Dataset features;  ///< those used
  /// How boards are turned against how the features were numbered, by image and
  /// board id: steps of Board::Turned(). Those that are not turned are left
  /// out.
  std::map<std::pair<std::string, int>, int> turns;
  /// Images whose boards differ from how they look after a turn by less than
  /// tells which way they are turned.
  std::vector<std::string> images_of_doubtful_turn;
  /// In all images; those that others stand for are the last.
  std::vector<BoardPose> poses;
  /// Groups of images that count as one: those that stand for the others are
  /// used, or held out.
  std::vector<SameViews> same_views;
  /// Images held out that show views which the camera was calibrated with.
  std::vector<std::string> held_out_copies;
  /// How far features moved when measured again through a first camera.
  std::optional<double> measured_again_rms_px;
  std::vector<FeatureResidual> training;
  /// The residuals of the images in hold_out, or else of cross-validation: each
  /// image localised with a camera calibrated without it.
  std::vector<FeatureResidual> held_out;
  /// The figures with boards that may bend from view to view: half of a
  /// held-out image's features tell how its board stands and bends, the errors
  /// are those of the other half.
  std::optional<ErrorFigures> held_out_flexed;
  bool cross_validated = false;
  /// Images with large held-out errors because no other image shows what they
  /// do: their own features fit, and without them the camera is unknown there.
  std::vector<std::string> images_alone;
  std::optional<BoardBends> bends;  ///< none of rigid boards
  std::vector<RejectedImage> rejected_images;
  std::vector<FeatureResidual> rejected_features;
  std::optional<TwoCameras> two_cameras;
  std::vector<CellCandidate> cell_candidates;
  std::vector<ModelCandidate> model_candidates;  ///< of model "auto"
  double cell_px = 0;  ///< of the grid; 0 for a parametric model
  int num_parameters = 0;
  bool converged = false;
  /// The checkpoint of a calibration that was told to stop before it was done.
  std::optional<Checkpoint> checkpoint;
  std::optional<double> bias_kl;
  std::optional<double> noise_bias_kl;  ///< what pure noise would have
  /// The parametric models, for comparison; noncentral-generic, too, where a
  /// central one errs alike between neighbours.
  std::vector<ModelFigures> parametric_models;
  /// The part of the median held-out error that a richer model does not have.
  std::optional<double> model_error_px;
  /// The correlation between neighbours of the held-out residuals, or else of
  /// the training ones.
  std::optional<double> neighbor_correlation;
  /// As in CameraUncertainty, which camera files do not hold.
  double jackknife_scale = 1;
  /// Nothing without an uncertainty.
  std::optional<ExtrapolatedRegion> extrapolated;
  std::optional<LineSpread> line_spread;  ///< of a camera that is not central
  FoldOver fold_over;
  double flat_board_height_m = 0;  ///< as in CalibrationFigures
  /// From the fleet that the grid lies around; nothing without a spread.
  std::optional<FleetDistance> fleet_distance;
  std::optional<RowTimeEstimate> row_time;  ///< if it was asked for
  /// The causes of the training residuals; none of an interrupted calibration.
  std::optional<ResidualBudget> budget;
  Verdict verdict;
};

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_CALIBRATION_RESULT_H
