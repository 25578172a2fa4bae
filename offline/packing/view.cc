#include "packing/view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "camera/opencv.h"
#include "camera/rotated_camera.h"
#include "camera/view_camera.h"
#include "dataset/camera_file.h"

namespace raygrid {
namespace {

// Returns the angle from the optical axis of a point on an axis of the image
// plane, clamped to the domain of the projection.
double ComputeAxisAngle(ViewProjection projection, int axis,
                        double coordinate) {
  switch (projection) {
    case ViewProjection::kPinhole:
      return std::atan(coordinate);
    case ViewProjection::kCylindrical:
      return axis == 0 ? std::clamp(coordinate, -M_PI, M_PI)
                       : std::atan(coordinate);
    case ViewProjection::kStereographic:
      return 2 * std::atan(coordinate / 2);
    case ViewProjection::kEquirectangular:
      if (axis == 1) return std::clamp(coordinate, -M_PI / 2, M_PI / 2);
      break;
    case ViewProjection::kEquidistant:
      break;
  }
  return std::clamp(coordinate, -M_PI, M_PI);
}

}  // namespace

std::optional<Eigen::Vector3d> VirtualView::Direction(
    const Eigen::Vector2d& pixel) const {
  const auto direction =
      PlaneDirection(projection, (pixel - center_px).cwiseQuotient(focal_px));
  if (!direction) return std::nullopt;
  return camera_from_view * *direction;
}

std::optional<Eigen::Vector2d> VirtualView::Pixel(
    const Eigen::Vector3d& direction) const {
  const Eigen::Vector3d turned = camera_from_view.transpose() * direction;
  if (!ContainsDirection(projection, turned)) return std::nullopt;
  return PlanePoint(projection, turned).cwiseProduct(focal_px) + center_px;
}

double ComputeFieldOfViewDeg(ViewProjection projection, int axis,
                             double focal_px, double center_px, int pixels) {
  return (ComputeAxisAngle(projection, axis, (center_px + 0.5) / focal_px) +
          ComputeAxisAngle(projection, axis,
                           (pixels - 0.5 - center_px) / focal_px)) *
         180 / M_PI;
}

double VirtualView::HorizontalFieldOfViewDeg() const {
  return ComputeFieldOfViewDeg(projection, 0, focal_px.x(), center_px.x(),
                               size.width);
}

double VirtualView::VerticalFieldOfViewDeg() const {
  return ComputeFieldOfViewDeg(projection, 1, focal_px.y(), center_px.y(),
                               size.height);
}

Eigen::Matrix3d RotationFromAngles(const Eigen::Vector3d& yaw_pitch_roll_deg) {
  if (yaw_pitch_roll_deg.isZero(0)) return Eigen::Matrix3d::Identity();
  const Eigen::Vector3d angle = yaw_pitch_roll_deg * M_PI / 180;
  return (Eigen::AngleAxisd(angle[0], Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(angle[1], Eigen::Vector3d::UnitX()) *
          Eigen::AngleAxisd(angle[2], Eigen::Vector3d::UnitZ()))
      .toRotationMatrix();
}

Eigen::Vector3d RotationToAngles(const Eigen::Matrix3d& camera_from_view) {
  const Eigen::Matrix3d& r = camera_from_view;
  const double across = std::hypot(r(0, 2), r(2, 2));
  // For a vertical optical axis, yaw and roll are redundant: yaw is set to 0.
  const bool is_vertical = across < 1e-12;
  const double yaw = is_vertical ? 0 : std::atan2(r(0, 2), r(2, 2));
  const double roll = is_vertical ? std::atan2(-r(0, 1), r(0, 0))
                                  : std::atan2(r(1, 0), r(1, 1));
  return Eigen::Vector3d(yaw, std::atan2(-r(1, 2), across), roll) * 180 / M_PI;
}

std::unique_ptr<CameraModel> MakeViewCamera(const VirtualView& view) {
  if (view.projection != ViewProjection::kPinhole)
    return std::make_unique<ViewCamera>(
        view.projection, view.size, WholeImage(view.size),
        Eigen::Vector4d(view.focal_px.x(), view.focal_px.y(),
                        view.center_px.x(), view.center_px.y()));
  OpenCvModel::ParameterArray parameters = {};
  parameters[OpenCvModel::kFx] = view.focal_px.x();
  parameters[OpenCvModel::kFy] = view.focal_px.y();
  parameters[OpenCvModel::kCx] = view.center_px.x();
  parameters[OpenCvModel::kCy] = view.center_px.y();
  return std::make_unique<OpenCvModel>(view.size, WholeImage(view.size),
                                       parameters);
}

std::unique_ptr<CameraModel> MakeRotatedViewCamera(const VirtualView& view) {
  return std::make_unique<RotatedCamera>(
      *MakeViewCamera(view), Eigen::Quaterniond(view.camera_from_view));
}

std::optional<VirtualView> MakeCameraView(const CameraModel& camera) {
  const Eigen::VectorXd parameters = camera.Parameters();
  VirtualView view;
  if (const auto* own = dynamic_cast<const ViewCamera*>(&camera))
    view.projection = own->projection();
  else if (camera.Name() != models::kOpenCv ||
           !parameters.tail(OpenCvModel::kCount - OpenCvModel::kK1).isZero(0))
    return std::nullopt;
  view.size = camera.image_size();
  view.focal_px = parameters.head<2>();
  view.center_px = parameters.segment<2>(2);
  return view;
}

std::string ViewCameraFile(const VirtualView& view, const std::string& name) {
  CameraFile file;
  file.camera = MakeViewCamera(view);
  file.name = name;
  if (view.IsTurned())
    file.camera_from_view =
        Pose{Eigen::Quaterniond(view.camera_from_view), {0, 0, 0}};
  return FormatCameraFile(file);
}

}  // namespace raygrid
