#include "simulation/noncentral_simulated_camera.h"

#include <cmath>
#include <limits>

#include "camera/pixel_search.h"
#include "camera/stereographic.h"

namespace raygrid {
namespace {

constexpr double kStepPx = 0.01;   // step of finite differences
constexpr double kGrazing = 0.02;  // minimum cosine of the angle of incidence

// Returns the angular error between a pixel's line and a point, in the chart;
// NaN if the pixel has no line.
Eigen::Vector2d LineError(const CameraModel& lens, const Eigen::Vector3d& point,
                          const Eigen::Vector2d& pixel) {
  const auto line = lens.Line(pixel);
  if (!line)
    return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  return ToChart(point - line->origin) - ToChart(line->direction);
}

// Finds the pixel whose line passes through a point. Pixels keep a distance
// from the area's edge, so that finite differences are possible.
std::optional<PixelSolution> FindLineThroughPoint(
    const CameraModel& lens, const Eigen::Vector3d& point,
    const Eigen::Vector2d* start) {
  const auto error = [&](const Eigen::Vector2d& pixel,
                         Eigen::Matrix2d* derivative) -> Eigen::Vector2d {
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector2d step = kStepPx * Eigen::Vector2d::Unit(k);
      derivative->col(k) = (LineError(lens, point, pixel - step) -
                            LineError(lens, point, pixel + step)) /
                           (2 * kStepPx);
    }
    return LineError(lens, point, pixel);
  };
  return FindPixel(lens.area(), start ? *start : lens.area().center(),
                   -2 * kStepPx, error);
}

}  // namespace

std::optional<Eigen::Vector3d> NoncentralSimulatedCamera::Unproject(
    const Eigen::Vector2d& pixel) const {
  const auto line = Line(pixel);
  if (!line) return std::nullopt;
  return line->direction;
}

std::optional<Eigen::Vector2d> NoncentralSimulatedCamera::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* start,
    double margin_px) const {
  const auto solution = FindLineThroughPoint(*this, point, start);
  if (!solution || !area().Contains(solution->pixel, margin_px))
    return std::nullopt;
  return solution->pixel;
}

bool NoncentralSimulatedCamera::Linearize(
    const Eigen::Vector3d& point, const Eigen::Vector2d* start,
    double margin_px, LinearizedProjection* projection) const {
  const auto solution = FindLineThroughPoint(*this, point, start);
  if (!solution || !area().Contains(solution->pixel, margin_px)) return false;
  projection->pixel = solution->pixel;
  projection->J_point =
      solution->derivative.inverse() *
      ToChartDerivative(point - Line(solution->pixel)->origin);
  return true;
}

std::optional<ObservationLine> MovingPupilCamera::Line(
    const Eigen::Vector2d& pixel) const {
  const auto direction = lens_->Unproject(pixel);
  if (!direction) return std::nullopt;
  const double theta = std::atan2(direction->head<2>().norm(), direction->z());
  return ObservationLine{{0, 0, shift_m_ * theta * theta}, *direction};
}

std::optional<ObservationLine> CoverGlassCamera::Line(
    const Eigen::Vector2d& pixel) const {
  const auto line = lens_->Line(pixel);
  if (!line) return std::nullopt;
  const Eigen::Vector3d& d = line->direction;
  const Eigen::Vector3d normal(std::sin(plate_.tilt_rad), 0,
                               std::cos(plate_.tilt_rad));
  const double cosine = normal.dot(d);
  if (!(cosine > kGrazing)) return std::nullopt;
  const double to_plate =
      (normal.z() * plate_.distance_m - normal.dot(line->origin)) / cosine;
  // Snell's law: the component along the face is divided by the refractive
  // index.
  const Eigen::Vector3d along = (d - cosine * normal) / plate_.refractive_index;
  const double cosine_inside = std::sqrt(1 - along.squaredNorm());
  const Eigen::Vector3d through =
      plate_.thickness_m * (along / cosine_inside + normal);
  return ObservationLine{line->origin + to_plate * d + through, d};
}

}  // namespace raygrid
