/// Experiments, as in the paper, on simulated truth or, where this makes sense,
/// on a user's own data: each has a name, and gives a table and a chart of it,
/// some pictures as well. A new one is a function and a line in Experiments().
#ifndef RAYGRID_EXPERIMENTS_EXPERIMENT_H
#define RAYGRID_EXPERIMENTS_EXPERIMENT_H

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "camera/area.h"
#include "camera/camera_model.h"
#include "camera/camera_uncertainty.h"
#include "dataset/dataset.h"
#include "dataset/image_files.h"
#include "evaluation/calibration_result.h"
#include "experiments/chart.h"
#include "experiments/colmap_model.h"

namespace raygrid {

struct NamedCamera {
  std::string name;
  std::shared_ptr<const CameraModel> model;
  std::optional<TrustMask> known = {};  ///< where it is, if that is told
};

/// Two cameras of one rig.
struct NamedStereo {
  std::string name;
  std::shared_ptr<const CameraModel> left, right;
  Pose right_from_left;
  std::optional<TrustMask> left_known = {};  ///< where, if that is told
  std::optional<TrustMask> right_known = {};
};

/// A user's data, to use instead of what would be simulated.
struct ExperimentData {
  std::optional<Dataset> features;
  std::optional<std::array<Dataset, 2>> pair_features;  ///< of two cameras
  Pattern pattern;                                      ///< of the features
  std::vector<std::string> hold_out;  ///< images not to calibrate with
  std::vector<NamedCamera> cameras;
  std::optional<CalibrationResult> result;  ///< with budget facts, if known
  std::optional<ColmapModel> walk;
  std::vector<NamedStereo> rigs;
  std::vector<std::string> images;  ///< paths
  double nearest_m = 0;             ///< of what they show; 0 if not told
};

/// The options that all experiments have.
struct ExperimentOptions {
  int num_images = 24;
  ImageSize size = {640, 480};
  double blur_px = 0.7;   ///< of the lens, standard deviation
  double read_noise = 2;  ///< standard deviation, grey levels
  int num_walks = 3;      ///< of trajectory-drift
  bool fine = false;      ///< model-validation: in the paper's regime
  std::vector<double> bump_widths_px = {20, 40,
                                        60};  ///< with fine: a lens each
  uint64_t seed = 0;
  int num_threads = 0;                   ///< 0 means all cores
  std::function<void(double)> progress;  ///< from 0 to 1, if any
  ExperimentData data;
};

struct Condition {
  std::string name, value;
};

using Cell = std::variant<std::string, int, double>;

/// NAME-name.png.
struct ExperimentPicture {
  std::string name;
  Image image;
};

struct ExperimentResult {
  std::vector<Condition> conditions;  ///< under which it was done
  std::vector<std::string> columns;
  std::vector<std::vector<Cell>> rows;
  Chart chart;
  std::vector<ExperimentPicture> pictures;
};

struct Experiment {
  std::string name, summary;
  ExperimentResult (*run)(const ExperimentOptions&);
  int num_images = 24;                    ///< unless asked for others
  std::vector<std::string> user_options;  ///< which name data of the user's
};

const std::vector<Experiment>& Experiments();

/// The error of the localisation against the number of star segments (paper,
/// "Calibration Pattern Evaluation"; there by reprojection errors).
ExperimentResult ComparePatternSegments(const ExperimentOptions& options);

/// The error that each refinement leaves (paper, "Feature Refinement
/// Evaluation"; there by reprojection errors).
ExperimentResult CompareFeatureRefinements(const ExperimentOptions& options);

/// All models at several resolutions, calibrated from the same features (paper,
/// "Validation of the Generic Model"): errors on training and other images, and
/// how far their residuals are from noise.
ExperimentResult ValidateModels(const ExperimentOptions& options);

/// Parametric models fitted to a generic camera: where they differ, and by how
/// much (paper, "Comparison of Models").
ExperimentResult CompareModelsByFit(const ExperimentOptions& options);

/// Beyond the paper: the error of rays that refinement by symmetry leaves
/// behind a wide lens if the mapping within its window is taken for a
/// homography. Residuals do not show it. Of a user's images, by how much the
/// curvature moves features.
ExperimentResult MeasureCurvatureBias(const ExperimentOptions& options);

/// How far a camera's lines are from meeting in a point, and what that does to
/// a central camera at other distances than those of the calibration.
ExperimentResult MeasureNoncentrality(const ExperimentOptions& options);

/// The error of a camera's place by 15 known points (paper, "Camera
/// Localization"), of one image and of the mean of many.
ExperimentResult LocalizeByModels(const ExperimentOptions& options);

/// Depth by stereo with generic and parametric calibrations of the same two
/// cameras (paper, "Stereo Depth Estimation"); of a user's pair of images,
/// against that of the last of the user's rigs.
ExperimentResult MeasureStereoDepth(const ExperimentOptions& options);

/// How far a walk ends from where it should, adjusted with each calibration
/// (paper, "Camera Trajectory Estimation"); a user's from where it ends with
/// the last of the cameras.
ExperimentResult MeasureTrajectoryDrift(const ExperimentOptions& options);

/// How well a camera calibrated from half of the images repeats that of the
/// other half, beside what their stated deviations predict.
ExperimentResult MeasureRepeatability(const ExperimentOptions& options);

/// Splits a calibration's residuals by cause: of simulated faults, whose cause
/// is known, or of a user's calibration.
ExperimentResult SplitResiduals(const ExperimentOptions& options);

/// How many images a simulated operator takes until a camera is known, who
/// follows the next view of capture, ROS's bars or nothing.
ExperimentResult CompareCaptureGuidance(const ExperimentOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_EXPERIMENT_H
