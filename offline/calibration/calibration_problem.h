#ifndef RAYGRID_CALIBRATION_CALIBRATION_PROBLEM_H
#define RAYGRID_CALIBRATION_CALIBRATION_PROBLEM_H

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "adjustment/adjustment_state.h"
#include "camera/lens_spread.h"
#include "dataset/dataset.h"
#include "evaluation/calibration_result.h"
#include "initialization/localization.h"

namespace raygrid {

/// The observations as adjustment wants them, and what they came from.
struct CalibrationProblem {
  std::vector<ImageSize> image_sizes;  ///< of each camera
  AreaChoice area = AreaChoice::kWholeImage;
  /// The model of the lenses that grids lie around, once ChooseBaseModel() has
  /// chosen it.
  std::string base_model = {};
  /// A camera of a like lens, which grids lie around; or none.
  std::shared_ptr<const CameraModel> like = {};
  /// How lenses differ from it, if that is known.
  std::shared_ptr<const LensSpread> prior_spread = {};
  std::vector<View> views;
  std::vector<std::string> images;  ///< of each view
  std::vector<int> boards;          ///< index in the pattern, of each view
  int num_poses = 0;                ///< of one body at one instant each
  std::vector<int> first_points;    ///< of each board
  /// Of boards that are fixed to others (JoinBoards()): the board whose frame
  /// is that of the body, and its place on it. Empty if none are.
  std::vector<int> frames, places;
  std::vector<Eigen::Vector3d> nominal;

  /// The feature that a view's observation was made of.
  Feature GetFeature(const Pattern& pattern, int view,
                     const Observation& observation) const;
};

/// The fewest features of one board in one image that are used.
constexpr size_t kMinViewFeatures = 8;

/// One view for each board in each image of each camera. Images of one name are
/// one instant: their views of a board share its pose.
CalibrationProblem BuildProblem(const std::vector<Dataset>& cameras,
                                const Pattern& pattern,
                                std::vector<RejectedImage>* rejected);

/// Removes views, and poses that none is left of.
void RemoveViews(const std::vector<bool>& remove, CalibrationProblem* problem);

/// The rectangle of a camera's features, rounded outwards to what a blob can
/// say.
Area FeatureArea(const CalibrationProblem& problem, int camera);
/// A camera's observations.
std::vector<Eigen::Vector2d> ObservedPixels(const CalibrationProblem& problem,
                                            int camera);

/// The area that a camera is calibrated over.
Area CalibratedArea(const CalibrationProblem& problem, int camera);

/// The modes in which the boards may bend from view to view.
DeformationModes GetDeformationModes(const CalibrationProblem& problem);

std::vector<PointPixelMatch> MakeMatches(
    const View& view, const std::vector<Eigen::Vector3d>& points);

/// camera_from_pattern of each view of a camera, with the nominal points;
/// nothing for other cameras' views.
std::vector<std::optional<Pose>> LocalizeViews(
    const CameraModel& camera, int camera_index,
    const CalibrationProblem& problem, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CALIBRATION_PROBLEM_H
