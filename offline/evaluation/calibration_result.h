#ifndef RAYGRID_EVALUATION_CALIBRATION_RESULT_H
#define RAYGRID_EVALUATION_CALIBRATION_RESULT_H

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dataset/camera_file.h"
#include "dataset/dataset.h"
#include "evaluation/assessment.h"
#include "evaluation/checkpoint.h"
#include "evaluation/fleet_distance.h"
#include "evaluation/fold_over.h"
#include "evaluation/noncentrality.h"
#include "evaluation/residual_budget.h"
#include "evaluation/residual_statistics.h"
#include "evaluation/uncertainty_summary.h"

namespace raygrid {

/// A rejected image, and the reason for its rejection.
struct RejectedImage {
  std::string image, reason;
  bool has_too_few_features = false;
};

/// A group of near-duplicate images, and the one that is used.
struct NearDuplicates {
  std::string image;
  std::vector<std::string> others;
};

/// Per-view deformation of the boards relative to their mean shape.
struct BoardDeformation {
  struct View {
    std::string image;
    int board = 0;
    double rms_m = 0;  ///< RMS deviation of the points from the mean shape
  };
  std::vector<View> views;
  double rms_m = 0;  ///< over all views
  /// The view with the largest deformation: its index, and point heights.
  int most_deformed = 0;
  std::vector<double> heights_m;
};

/// A knot spacing that was compared, and its held-out error.
struct KnotSpacingCandidate {
  double knot_spacing_px = 0;
  double loss = 0;  ///< mean held-out Huber loss, px^2
  double median_px = 0;
};

/// A model that was compared, and its error in cross-validation.
struct ModelCandidate {
  std::string model;
  double loss = 0;  ///< mean held-out Huber loss, px^2
  double median_px = 0;
  double gain =
      0;  ///< gain over the grid, in standard errors of the difference
};

/// Metrics of another model, fitted to the same training features and evaluated
/// on the same held-out features.
struct ModelMetrics {
  std::string model;
  int num_parameters = 0;
  ErrorMetrics training;
  std::optional<ErrorMetrics> held_out, held_out_deformed;
  std::optional<double> bias_kl;
  std::vector<FeatureResidual> held_out_residuals;  ///< not written to files
};

/// The calibration result of one camera, alone or in a rig.
struct CalibrationResult {
  CameraFile camera;
  Pattern pattern;   ///< estimated pattern
  Dataset features;  ///< features used
  /// Rotations of boards relative to the numbering of the features, by image
  /// and board id, in steps of Board::Rotated(). Boards without rotation are
  /// omitted.
  std::map<std::pair<std::string, int>, int> turns;
  /// Images in which the orientation of a rotationally symmetric board is
  /// ambiguous.
  std::vector<std::string> ambiguous_rotation_images;
  /// Target poses of all images; near-duplicates last.
  std::vector<BoardPose> poses;
  /// Groups of near-duplicates; one image of each group is used or held out.
  std::vector<NearDuplicates> near_duplicates;
  /// Held-out images that are near-duplicates of calibration images.
  std::vector<std::string> held_out_duplicates;
  /// RMS change of features by refinement with a first camera.
  std::optional<double> refinement_rms_px;
  std::vector<FeatureResidual> training;
  /// Residuals of the images in hold_out, or of cross-validation: each image
  /// localized with a camera calibrated without it.
  std::vector<FeatureResidual> held_out;
  /// Held-out errors with per-view deformation: pose and deformation are
  /// estimated from half of a held-out image's features, and errors evaluated
  /// on the other half.
  std::optional<ErrorMetrics> held_out_deformed;
  bool cross_validated = false;
  /// Images with large held-out errors because no other image covers some
  /// region: without them, the camera is extrapolated there.
  std::vector<std::string> unique_coverage_images;
  std::optional<BoardDeformation>
      bends;  ///< nullopt without per-view deformation
  std::vector<RejectedImage> rejected_images;
  std::vector<FeatureResidual> rejected_features;
  std::optional<MixedCameras> mixed_cameras;
  std::optional<TransformedImages> transformed_images;
  std::vector<KnotSpacingCandidate> knot_spacing_candidates;
  std::vector<ModelCandidate> model_candidates;  ///< candidates of model "auto"
  double knot_spacing_px = 0;  ///< knot spacing; 0 for a parametric model
  /// The camera was given: its intrinsics and uncertainty are kept.
  bool has_known_intrinsics = false;
  int num_parameters = 0;
  bool converged = false;
  /// The checkpoint of a calibration that was interrupted.
  std::optional<Checkpoint> checkpoint;
  std::optional<double> bias_kl;
  std::optional<double> noise_bias_kl;  ///< expected for pure noise
  /// Parametric models for comparison; also noncentral-generic if the residuals
  /// of a central model are correlated.
  std::vector<ModelMetrics> parametric_models;
  // Metrics that consist of a single number.
#define RAYGRID_METRIC(name, ...) std::optional<double> name;
#include "evaluation/metrics.inc"
  /// Scale of the standard deviations, estimated by jackknife; see
  /// CameraUncertainty. Not stored in camera files.
  double jackknife_scale = 1;
  /// Extrapolated region; nullopt without a predicted uncertainty.
  std::optional<ExtrapolatedRegion> extrapolated;
  std::optional<Noncentrality> noncentrality;  ///< line spread of a non-central
                                               ///< camera
  FoldOver fold_over;
  double flatness_error_m = 0;  ///< see CalibrationMetrics
  /// Distance from the prior fleet; nullopt without the fleet's variation.
  std::optional<FleetDistance> fleet_distance;
  std::optional<LineDelayEstimate> line_delay;  ///< if requested
  /// Causes of the training residuals; nullopt if interrupted.
  std::optional<ResidualBudget> budget;
  Assessment assessment;
};

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_CALIBRATION_RESULT_H
