#include "camera/sensor_mode.h"

#include <algorithm>

namespace raygrid {
namespace {

// Returns the area of a mode's frames that the calibrated area covers.
Area TransformAreaToMode(const Area& area, const SensorMode& mode) {
  const Eigen::Vector2d a = mode.FromCalibrated({area.x0, area.y0});
  const Eigen::Vector2d b = mode.FromCalibrated({area.x1, area.y1});
  const Area image = WholeImage(mode.size);
  return {std::max(std::min(a.x(), b.x()), image.x0),
          std::max(std::min(a.y(), b.y()), image.y0),
          std::min(std::max(a.x(), b.x()), image.x1),
          std::min(std::max(a.y(), b.y()), image.y1)};
}

// Returns the image circle in a mode's frames.
std::optional<ImageCircle> TransformCircleToMode(
    const std::optional<ImageCircle>& circle, const SensorMode& mode) {
  if (!circle) return std::nullopt;
  return ImageCircle{mode.FromCalibrated(circle->center),
                     circle->radii_px.cwiseQuotient(mode.scale)};
}

}  // namespace

Eigen::Vector2d SensorMode::ToCalibrated(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d counted(
      flip_x ? size.width - 1 - pixel.x() : pixel.x(),
      flip_y ? size.height - 1 - pixel.y() : pixel.y());
  return (counted.array() + 0.5) * scale.array() + offset_px.array() - 0.5;
}

Eigen::Vector2d SensorMode::FromCalibrated(const Eigen::Vector2d& pixel) const {
  const Eigen::Array2d counted =
      (pixel.array() + 0.5 - offset_px.array()) / scale.array() - 0.5;
  return {flip_x ? size.width - 1 - counted.x() : counted.x(),
          flip_y ? size.height - 1 - counted.y() : counted.y()};
}

ModeCamera::ModeCamera(const CameraModel& camera, const SensorMode& mode)
    : CameraWrapper(camera, mode.size,
                    TransformAreaToMode(camera.area(), mode)),
      mode_(mode) {
  SetImageCircle(TransformCircleToMode(camera.image_circle(), mode));
}

std::optional<Eigen::Vector3d> ModeCamera::Unproject(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  return camera().Unproject(mode_.ToCalibrated(pixel));
}

std::optional<ObservationLine> ModeCamera::Line(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  return camera().Line(mode_.ToCalibrated(pixel));
}

std::optional<Eigen::Vector2d> ModeCamera::Project(const Eigen::Vector3d& point,
                                                   const Eigen::Vector2d* start,
                                                   double margin_px) const {
  const Eigen::Vector2d calibrated_start =
      start ? mode_.ToCalibrated(*start) : Eigen::Vector2d::Zero();
  const auto calibrated =
      camera().Project(point, start ? &calibrated_start : nullptr,
                       margin_px * mode_.scale.maxCoeff());
  if (!calibrated) return std::nullopt;
  const Eigen::Vector2d pixel = mode_.FromCalibrated(*calibrated);
  if (!area().Contains(pixel, margin_px)) return std::nullopt;
  return pixel;
}

bool ModeCamera::Linearize(const Eigen::Vector3d& point,
                           const Eigen::Vector2d* start, double margin_px,
                           LinearizedProjection* projection) const {
  const Eigen::Vector2d calibrated_start =
      start ? mode_.ToCalibrated(*start) : Eigen::Vector2d::Zero();
  if (!camera().Linearize(point, start ? &calibrated_start : nullptr,
                          margin_px * mode_.scale.maxCoeff(), projection))
    return false;
  const Eigen::Vector2d signed_scale = mode_.scale.cwiseProduct(
      Eigen::Vector2d(mode_.flip_x ? -1 : 1, mode_.flip_y ? -1 : 1));
  projection->pixel = mode_.FromCalibrated(projection->pixel);
  projection->J_point =
      (signed_scale.cwiseInverse().asDiagonal() * projection->J_point).eval();
  ForgetParameters(projection);
  return area().Contains(projection->pixel, margin_px);
}

}  // namespace raygrid
