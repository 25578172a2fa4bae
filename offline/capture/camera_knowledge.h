#ifndef RAYGRID_CAPTURE_CAMERA_KNOWLEDGE_H
#define RAYGRID_CAPTURE_CAMERA_KNOWLEDGE_H

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "calibration/model_adjustment.h"
#include "dataset/pattern.h"
#include "initialization/localization.h"

namespace raygrid {

/// The part of an image in which features are found: a feature's window must
/// not leave the image.
Area AreaOfFeatures(const ImageSize& size);

/// The features of a board that detection would find, in the board's frame.
std::vector<PointOnPixel> SeenPoints(const CameraModel& camera,
                                     const Board& board,
                                     const Pose& camera_from_board);

/// How well a place of the image is known: the root mean square of how far its
/// ray may be seen from there.
struct KnownPlace {
  Eigen::Vector2d pixel;
  double deviation_px = 0;
};

/// Knowledge of a camera that the images so far give, and what one more would
/// add to it.
///
/// With the parameters' matrix H = P + sum over views of J^T J, the prior P and
/// each view's pose eliminated from J, pixels whose moves with the parameters
/// are D scatter by s^2 D H^-1 D^T. A view with J' more takes away
///   s^2 D H^-1 J'^T (1 + J' H^-1 J'^T)^-1 J' H^-1 D^T.
/// Boards are as they are nominally.
class CameraKnowledge {
 public:
  /// The knowledge of an adjusted camera; nothing if its equations are
  /// singular.
  static std::optional<CameraKnowledge> Of(const Adjusted& adjusted);

  const CameraModel& camera() const { return *camera_; }
  /// From corner to corner of the image, row by row, where the camera tells.
  const std::vector<KnownPlace>& places() const { return places_; }
  /// The square root of the mean variance over the places.
  double RmsPx() const;
  /// The deviation that 95 % of the places stay below.
  double Percentile95Px() const;

  /// The part of the mean variance that a view of a board, camera_from_board,
  /// would take away: from 0, of nothing, to less than 1. It has the features
  /// that the camera would see, and detection find.
  double GainOfView(const Board& board, const Pose& camera_from_board) const;
  /// The gain of features that are seen.
  double GainOf(const std::vector<Eigen::Vector3d>& points,
                const std::vector<Eigen::Vector2d>& pixels,
                const Pose& camera_from_points) const;

 private:
  CameraKnowledge() = default;

  std::unique_ptr<CameraModel> camera_;
  std::vector<KnownPlace> places_;
  Eigen::MatrixXd inverse_;   // H^-1
  Eigen::MatrixXd weighing_;  // H^-1 D^T D H^-1 / tr(D H^-1 D^T)
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAMERA_KNOWLEDGE_H
