#ifndef RAYGRID_CAMERA_SENSOR_MODE_H
#define RAYGRID_CAMERA_SENSOR_MODE_H

#include <Eigen/Core>
#include <memory>
#include <string>

#include "camera/camera_wrapper.h"

namespace raygrid {

/// Position of a sensor mode's frames in calibrated frames: pixel (i, j),
/// counted from the opposite side if flipped, covers the calibrated pixels from
/// offset + scale (i, j), scale of them per side. A crop has scale 1, binning
/// by two has scale 2.
struct SensorMode {
  std::string name;
  ImageSize size;                                       ///< frame size
  Eigen::Vector2d offset_px = Eigen::Vector2d::Zero();  ///< calibrated pixels
  Eigen::Vector2d scale = Eigen::Vector2d::Ones();
  bool flip_x = false, flip_y = false;

  /// Converts a position in the mode's frames to calibrated frames, and back;
  /// pixel centres are integers in both.
  Eigen::Vector2d ToCalibrated(const Eigen::Vector2d& pixel) const;
  Eigen::Vector2d FromCalibrated(const Eigen::Vector2d& pixel) const;
};

/// A camera in frames of another mode, with exactly the same lines.
class ModeCamera : public CameraWrapper {
 public:
  /// Frames of the mode must lie within the calibrated area.
  ModeCamera(const CameraModel& camera, const SensorMode& mode);

  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<ModeCamera>(camera(), mode_);
  }
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override;
  std::optional<ObservationLine> Line(
      const Eigen::Vector2d& pixel) const override;
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override;
  using CameraModel::Project;
  bool Linearize(const Eigen::Vector3d& point, const Eigen::Vector2d* start,
                 double margin_px,
                 LinearizedProjection* projection) const override;

 private:
  SensorMode mode_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_SENSOR_MODE_H
