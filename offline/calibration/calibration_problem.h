#ifndef RAYGRID_CALIBRATION_CALIBRATION_PROBLEM_H
#define RAYGRID_CALIBRATION_CALIBRATION_PROBLEM_H

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "adjustment/adjustment_state.h"
#include "camera/population_covariance.h"
#include "dataset/dataset.h"
#include "evaluation/calibration_result.h"
#include "initialization/localization.h"

namespace raygrid {

/// Observations for bundle adjustment, and the images and boards that they
/// belong to.
struct CalibrationProblem {
  std::vector<ImageSize> image_sizes;  ///< sizes by camera
  AreaChoice area = AreaChoice::kWholeImage;
  /// Name of the base model of grids, set by ChooseBaseModel().
  std::string base_model = {};
  /// Prior camera that the grids' prior is centred on, or null.
  std::shared_ptr<const CameraModel> like = {};
  /// Variation over the fleet of the prior camera, or null.
  std::shared_ptr<const PopulationCovariance> prior_population = {};
  std::vector<View> views;
  std::vector<std::string> images;  ///< image name of each view
  std::vector<int> boards;          ///< pattern index of each view's board
  int num_poses = 0;                ///< one per target and frame
  std::vector<int> first_points;    ///< index of each board's first point
  /// For boards of rigid targets (JoinBoards()): the board that defines the
  /// target's frame, and the index into target_from_board. Empty if there are
  /// none.
  std::vector<int> frames, places;
  std::vector<Eigen::Vector3d> nominal;

  /// Returns the feature that corresponds to an observation of a view.
  Feature GetFeature(const Pattern& pattern, int view,
                     const Observation& observation) const;
};

/// Minimum number of features of one board in one image.
constexpr size_t kMinViewFeatures = 8;

/// Creates one view per board, image and camera. Images of the same name are
/// one frame: views of a board in it share the board's pose.
CalibrationProblem BuildProblem(const std::vector<Dataset>& cameras,
                                const Pattern& pattern,
                                std::vector<RejectedImage>* rejected);

/// Removes views, and poses without remaining views.
void RemoveViews(const std::vector<bool>& remove, CalibrationProblem* problem);

/// Returns the bounding rectangle of a camera's features, rounded outwards to
/// the resolution of a blob.
Area ComputeFeatureArea(const CalibrationProblem& problem, int camera);
/// Returns all observed pixels of a camera.
std::vector<Eigen::Vector2d> ObservedPixels(const CalibrationProblem& problem,
                                            int camera);

/// Returns the calibrated area of a camera.
Area ComputeCalibratedArea(const CalibrationProblem& problem, int camera);

/// Returns the deformation modes of the boards, per view.
DeformationModes GetDeformationModes(const CalibrationProblem& problem);

std::vector<PointPixelMatch> MakeMatches(
    const View& view, const std::vector<Eigen::Vector3d>& points);

/// Computes camera_from_pattern of each view of a camera with the nominal
/// points; nullopt if localization fails and for views of other cameras.
std::vector<std::optional<Pose>> LocalizeViews(
    const CameraModel& camera, int camera_index,
    const CalibrationProblem& problem, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CALIBRATION_PROBLEM_H
