/// A textured wall for stereo.
#ifndef RAYGRID_EXPERIMENTS_PAINTED_WALL_H
#define RAYGRID_EXPERIMENTS_PAINTED_WALL_H

#include <opencv2/core.hpp>
#include <optional>

#include "camera/camera_model.h"
#include "camera/pose.h"

namespace raygrid {

/// The wall z = distance + kSlope x in a camera's frame. The texture's scale is
/// proportional to the distance.
class PaintedWall {
 public:
  static constexpr double kSlope = 0.15;

  explicit PaintedWall(double distance_m) : distance_m_(distance_m) {}

  double distance_m() const { return distance_m_; }

  /// Intersects a line with the wall; nullopt if parallel or pointing away.
  std::optional<Eigen::Vector3d> IntersectRay(
      const ObservationLine& line) const;

  /// Renders an image without noise, as 32-bit floats; 0 outside the wall.
  cv::Mat Photograph(const CameraModel& camera, const Pose& wall_from_camera,
                     int num_threads) const;

 private:
  double EvaluateTexture(const Eigen::Vector3d& point) const;

  double distance_m_;
};

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_PAINTED_WALL_H
