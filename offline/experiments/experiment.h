/// Experiments as in the paper, with simulated ground truth or, where possible,
/// a user's data. Each has a name, and produces a table and a chart, and some
/// also pictures. To add one, write a function and add it to Experiments().
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
  std::optional<ValidityMask> known = {};  ///< valid region, if available
};

/// Two cameras of one rig.
struct StereoRig {
  std::string name;
  std::shared_ptr<const CameraModel> left, right;
  Pose right_from_left;
  std::optional<ValidityMask> left_known = {};  ///< valid region, if available
  std::optional<ValidityMask> right_known = {};
};

/// A user's data, used instead of a simulation.
struct ExperimentData {
  std::optional<Dataset> features;
  std::optional<std::array<Dataset, 2>> pair_features;  ///< two cameras
  Pattern pattern;                    ///< pattern of the features
  std::vector<std::string> hold_out;  ///< held-out images
  std::vector<NamedCamera> cameras;
  std::optional<CalibrationResult> result;  ///< with budget facts, if available
  std::optional<ColmapModel> trajectory;
  std::vector<StereoRig> rigs;
  std::vector<std::string> images;  ///< paths
  double min_distance_m = 0;        ///< scene distance; 0: not specified
};

/// Options common to all experiments.
struct ExperimentOptions {
  int num_images = 24;
  ImageSize size = {640, 480};
  double blur_px = 0.7;      ///< lens blur, standard deviation
  double read_noise = 2;     ///< standard deviation, grey levels
  int num_trajectories = 3;  ///< trajectories of trajectory-drift
  bool fine = false;         ///< model-validation in the paper's regime
  std::vector<double> bump_widths_px = {20, 40,
                                        60};  ///< with fine: one lens each
  uint64_t seed = 0;
  int num_threads = 0;                   ///< 0: all cores
  std::function<void(double)> progress;  ///< fraction done; may be empty
  ExperimentData data;
};

struct Condition {
  std::string name, value;
};

using Cell = std::variant<std::string, int, double>;

/// A picture, written to NAME-name.png.
struct ExperimentImage {
  std::string name;
  Image image;
};

struct ExperimentResult {
  std::vector<Condition> conditions;  ///< conditions of the experiment
  std::vector<std::string> columns;
  std::vector<std::vector<Cell>> rows;
  Chart chart;
  std::vector<ExperimentImage> pictures;
};

struct Experiment {
  std::string name, summary;
  ExperimentResult (*run)(const ExperimentOptions&);
  int num_images = 24;                    ///< default
  std::vector<std::string> user_options;  ///< options for the user's data
};

const std::vector<Experiment>& Experiments();

/// Measures the localization error by the number of star segments (paper,
/// "Calibration Pattern Evaluation"; there by reprojection errors).
ExperimentResult ComparePatternSegments(const ExperimentOptions& options);

/// Measures the error of each refinement method (paper, "Feature Refinement
/// Evaluation"; there by reprojection errors).
ExperimentResult CompareFeatureRefinements(const ExperimentOptions& options);

/// All models at several resolutions, calibrated from the same features (paper,
/// "Validation of the Generic Model"): training and held-out errors, and the
/// bias of their residuals.
ExperimentResult ValidateModels(const ExperimentOptions& options);

/// Fits parametric models to a generic camera: the distribution and size of
/// their differences (paper, "Comparison of Models").
ExperimentResult CompareModelsByFit(const ExperimentOptions& options);

/// Measures the error of rays (not in the paper) if refinement by symmetry
/// assumes a homography within the window of a wide-angle lens; residuals do
/// not reveal this error. For a user's images, measures the displacement of
/// features due to curvature.
ExperimentResult MeasureCurvatureBias(const ExperimentOptions& options);

/// Measures the non-centrality of a camera, and the resulting error of a
/// central model at distances other than those used for calibration.
ExperimentResult MeasureNoncentrality(const ExperimentOptions& options);

/// Measures the error of a camera's position from 15 known points (paper,
/// "Camera Localization"), for one image and for the mean of many.
ExperimentResult LocalizeByModels(const ExperimentOptions& options);

/// Measures stereo depth with generic and parametric calibrations of the same
/// two cameras (paper, "Stereo Depth Estimation"); for a user's pair of images,
/// relative to the last of the user's rigs.
ExperimentResult MeasureStereoDepth(const ExperimentOptions& options);

/// Measures the end-point drift of a trajectory optimized with each calibration
/// (paper, "Camera Trajectory Estimation"); for a user's trajectory, relative
/// to the end point with the last camera.
ExperimentResult MeasureTrajectoryDrift(const ExperimentOptions& options);

/// Compares the difference between cameras calibrated from each half of the
/// images with their predicted uncertainty.
ExperimentResult MeasureRepeatability(const ExperimentOptions& options);

/// Attributes a calibration's residuals to causes: simulated faults with a
/// known cause, or a user's calibration.
ExperimentResult SplitResiduals(const ExperimentOptions& options);

/// Counts the images that a simulated operator captures until a camera is
/// determined, guided by capture's next view, by ROS's progress bars, or
/// without guidance.
ExperimentResult CompareCaptureGuidance(const ExperimentOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_EXPERIMENT_H
