#include "simulation/simulated_camera.h"

#include <Eigen/LU>
#include <cmath>

namespace raygrid {
namespace {

constexpr double kBumpMarginPx = 50;

Area WidenArea(const Area& area) {
  return {area.x0 - kBumpMarginPx, area.y0 - kBumpMarginPx,
          area.x1 + kBumpMarginPx, area.y1 + kBumpMarginPx};
}

}  // namespace

SimulatedCamera::SimulatedCamera(const OpenCvModel& lens,
                                 std::vector<DistortionBump> bumps)
    : SimulatedCamera(
          std::make_shared<OpenCvModel>(lens.WithArea(WidenArea(lens.area()))),
          lens.area(), std::move(bumps)) {}

SimulatedCamera::SimulatedCamera(std::shared_ptr<const CameraModel> lens,
                                 const Area& area,
                                 std::vector<DistortionBump> bumps)
    : CameraModel(lens->image_size(), area),
      lens_(std::move(lens)),
      bumps_(std::move(bumps)) {}

Eigen::Vector2d SimulatedCamera::ApplyDistortionBumps(
    const Eigen::Vector2d& pixel, Eigen::Matrix2d* derivative) const {
  Eigen::Vector2d bent = pixel;
  *derivative = Eigen::Matrix2d::Identity();
  for (const DistortionBump& bump : bumps_) {
    const Eigen::Vector2d offset = pixel - bump.center;
    const double r2 = bump.radius_px * bump.radius_px;
    const Eigen::Vector2d shift =
        bump.displacement_px * std::exp(-offset.squaredNorm() / (2 * r2));
    bent += shift;
    *derivative -= shift * offset.transpose() / r2;
  }
  return bent;
}

std::optional<Eigen::Vector3d> SimulatedCamera::Unproject(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  Eigen::Vector2d without_bumps = pixel;
  for (int iteration = 0; iteration < 50; ++iteration) {
    Eigen::Matrix2d derivative;
    const Eigen::Vector2d error =
        pixel - ApplyDistortionBumps(without_bumps, &derivative);
    without_bumps += derivative.inverse() * error;
    if (error.norm() < 1e-12) break;
  }
  return lens_->Unproject(without_bumps);
}

std::optional<Eigen::Vector2d> SimulatedCamera::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* /*start*/,
    double margin_px) const {
  const auto straight = lens_->Project(point);
  if (!straight) return std::nullopt;
  Eigen::Matrix2d derivative;
  const Eigen::Vector2d pixel = ApplyDistortionBumps(*straight, &derivative);
  if (!area().Contains(pixel, margin_px)) return std::nullopt;
  return pixel;
}

bool SimulatedCamera::Linearize(const Eigen::Vector3d& point,
                                const Eigen::Vector2d* start, double margin_px,
                                LinearizedProjection* projection) const {
  if (!lens_->Linearize(point, start, 0, projection)) return false;
  Eigen::Matrix2d derivative;
  projection->pixel = ApplyDistortionBumps(projection->pixel, &derivative);
  projection->J_point = derivative * projection->J_point;
  return area().Contains(projection->pixel, margin_px);
}

SimulatedCamera ExampleSimulatedCamera() {
  const ImageSize size = {640, 480};
  const OpenCvModel::ParameterArray parameters = {
      530, 532, 322.3, 237.1, -0.28, 0.09, 0, 0, 0, 0, 7e-4, -4e-4};
  return SimulatedCamera(OpenCvModel(size, WholeImage(size), parameters),
                         {{{150, 120}, {0.9, -0.5}, 90},
                          {{480, 340}, {-0.7, 1.3}, 110},
                          {{330, 60}, {0.4, 0.8}, 70},
                          {{90, 400}, {-1.0, -0.6}, 100},
                          {{560, 130}, {0.8, 0.4}, 80}});
}

}  // namespace raygrid
