#include "simulation/asymmetric_camera.h"

#include <Eigen/LU>
#include <cmath>

#include "camera/stereographic.h"

namespace raygrid {
namespace {

using Place = Eigen::Vector2d;

// Converts between positions in an equidistant fisheye image, in radians, and
// directions.
Eigen::Vector3d FromFisheye(const Place& image) {
  const double theta = image.norm();
  const double scale = theta > 1e-9 ? std::sin(theta) / theta : 1;
  return {scale * image.x(), scale * image.y(), std::cos(theta)};
}

Place ToFisheye(const Eigen::Vector3d& direction) {
  const double across = direction.head<2>().norm();
  if (!(across > 1e-12 * direction.norm()))
    return direction.head<2>() / direction.z();
  return std::atan2(across, direction.z()) / across * direction.head<2>();
}

}  // namespace

Place AsymmetricCamera::PositionFromPixel(const Eigen::Vector2d& pixel) const {
  const ImageSize& size = image_size();
  const Eigen::Vector2d image_center((size.width - 1) / 2.0,
                                     (size.height - 1) / 2.0);
  return (pixel - image_center) / size.width;
}

std::optional<Eigen::Vector3d> AsymmetricCamera::Unproject(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  return DirectionFromPosition(PositionFromPixel(pixel)).normalized();
}

std::optional<Eigen::Vector2d> AsymmetricCamera::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* /*start*/,
    double margin_px) const {
  if (point.isZero(0)) return std::nullopt;
  const auto position = PositionFromDirection(point.normalized());
  if (!position) return std::nullopt;
  const ImageSize& size = image_size();
  const Eigen::Vector2d image_center((size.width - 1) / 2.0,
                                     (size.height - 1) / 2.0);
  const Eigen::Vector2d pixel = image_center + size.width * *position;
  if (!area().Contains(pixel, margin_px)) return std::nullopt;
  return pixel;
}

// The Jacobian of the projection is the inverse of the Jacobian of the
// direction, which is computed by finite differences.
bool AsymmetricCamera::Linearize(const Eigen::Vector3d& point,
                                 const Eigen::Vector2d* start, double margin_px,
                                 LinearizedProjection* projection) const {
  constexpr double kSlopeStepPx = 0.01;
  const auto pixel = Project(point, start, margin_px);
  if (!pixel) return false;
  Eigen::Matrix2d J_pixel;
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2d step = kSlopeStepPx * Eigen::Vector2d::Unit(k);
    J_pixel.col(k) =
        (ToChart(DirectionFromPosition(PositionFromPixel(*pixel + step))) -
         ToChart(DirectionFromPosition(PositionFromPixel(*pixel - step)))) /
        (2 * kSlopeStepPx);
  }
  projection->pixel = *pixel;
  projection->J_point = J_pixel.inverse() * ToChartDerivative(point);
  return true;
}

// ---- Anamorphic ------------------------------------------------------------

namespace {

constexpr double kLongitudes = 130 * M_PI / 180;  // over the image width

}  // namespace

Eigen::Vector3d AnamorphicCamera::DirectionFromPosition(
    const Place& position) const {
  const double longitude = kLongitudes * position.x();
  return {std::sin(longitude), kLongitudes / 2 * position.y(),
          std::cos(longitude)};
}

std::optional<Place> AnamorphicCamera::PositionFromDirection(
    const Eigen::Vector3d& direction) const {
  const double forward = std::hypot(direction.x(), direction.z());
  return Place(std::atan2(direction.x(), direction.z()) / kLongitudes,
               direction.y() / forward * 2 / kLongitudes);
}

// ---- Off axis --------------------------------------------------------------

namespace {

const Place kAxisPosition(1.0 / 3, 0.05);
constexpr double kOffAxisFocal = 0.5;  // image widths per radian
constexpr double kOffAxisTilt = -0.6;  // tilt t per radian

}  // namespace

Eigen::Vector3d OffAxisCamera::DirectionFromPosition(
    const Place& position) const {
  const Place tilted = (position - kAxisPosition) / kOffAxisFocal;
  return FromFisheye(tilted / (1 + kOffAxisTilt * tilted.x()));
}

std::optional<Place> OffAxisCamera::PositionFromDirection(
    const Eigen::Vector3d& direction) const {
  const Place fisheye = ToFisheye(direction);
  const double depth = 1 - kOffAxisTilt * fisheye.x();
  if (!(depth > 0.1)) return std::nullopt;
  return kAxisPosition + kOffAxisFocal * fisheye / depth;
}

// ---- Two halves ------------------------------------------------------------

namespace {

// Inverse focal lengths of the two halves, in 1 / image width: mean and half
// difference.
constexpr double kMeanInverseFocal = 1.5, kHalfDifference = 0.5;
constexpr double kTransitionHalfWidth =
    0.1;  // half-width of the transition, in widths

double InverseFocal(double x) {
  return kMeanInverseFocal -
         kHalfDifference * std::tanh(x / kTransitionHalfWidth);
}

double IntegrateInverseFocal(double x) {
  const double away = std::abs(x) / kTransitionHalfWidth;
  const double log_cosh = away + std::log1p(std::exp(-2 * away)) - M_LN2;
  return kMeanInverseFocal * x -
         kHalfDifference * kTransitionHalfWidth * log_cosh;
}

}  // namespace

Eigen::Vector3d TwoFocalLengthsCamera::DirectionFromPosition(
    const Place& position) const {
  return {IntegrateInverseFocal(position.x()),
          position.y() * InverseFocal(position.x()), 1};
}

std::optional<Place> TwoFocalLengthsCamera::PositionFromDirection(
    const Eigen::Vector3d& direction) const {
  if (!(direction.z() > 1e-3)) return std::nullopt;
  const double u = direction.x() / direction.z();
  // The integral is concave, so Newton's method converges monotonically.
  double x = u / (u > 0 ? kMeanInverseFocal - kHalfDifference
                        : kMeanInverseFocal + kHalfDifference);
  for (int iteration = 0; iteration < 50; ++iteration) {
    const double step = (u - IntegrateInverseFocal(x)) / InverseFocal(x);
    x += step;
    if (std::abs(step) < 1e-15) break;
  }
  return Place(x, direction.y() / direction.z() / InverseFocal(x));
}

// ---- Decentred -------------------------------------------------------------

namespace {

const Place kDecentredAxis(-0.1, 0.06);  // axis of the fisheye
constexpr double kDecentredFocal = 0.55;
const Place kSecondCentre(0.9, -0.6);  // in radians of the fisheye image
constexpr double kSecondBarrel = 0.05;

}  // namespace

Eigen::Vector3d DecentredCamera::DirectionFromPosition(
    const Place& position) const {
  const Place bent =
      (position - kDecentredAxis) / kDecentredFocal - kSecondCentre;
  // Inverts b = a / (1 + k a^2); the smaller solution is valid.
  const double b = bent.norm();
  const double root = std::sqrt(1 - 4 * kSecondBarrel * b * b);
  return FromFisheye(kSecondCentre + bent * 2 / (1 + root));
}

std::optional<Place> DecentredCamera::PositionFromDirection(
    const Eigen::Vector3d& direction) const {
  const Place offset = ToFisheye(direction) - kSecondCentre;
  const double a2 = offset.squaredNorm();
  if (!(kSecondBarrel * a2 < 0.95)) return std::nullopt;
  return kDecentredAxis +
         kDecentredFocal * (kSecondCentre + offset / (1 + kSecondBarrel * a2));
}

// ---- Mirror ----------------------------------------------------------------

namespace {

constexpr double kXi = 0.98;           // for an eccentricity of 1.22
constexpr double kMirrorFocal = 0.75;  // in image widths
// Tilt of the camera towards the mirror's flank, and perpendicular to it. The
// image corners are up to 143 degrees from the mirror's axis; the hyperboloid
// reaches 145 degrees.
constexpr double kCameraTiltRad = 37 * M_PI / 180;
constexpr double kCameraTiltDownRad = 4 * M_PI / 180;

}  // namespace

MirrorCamera::MirrorCamera(const ImageSize& size, const Area& area)
    : AsymmetricCamera(size, area),
      mirror_from_camera_(
          (Eigen::AngleAxisd(kCameraTiltRad, Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(kCameraTiltDownRad, Eigen::Vector3d::UnitX()))
              .toRotationMatrix()) {}

Eigen::Vector3d MirrorCamera::DirectionFromPosition(
    const Place& position) const {
  const Eigen::Vector3d seen =
      mirror_from_camera_ *
      Eigen::Vector3d(position.x(), position.y(), kMirrorFocal);
  // Intersects the ray from (0, 0, -xi) with the unit sphere.
  const Place m = seen.head<2>() / seen.z();
  const double r2 = m.squaredNorm();
  const double along = (kXi + std::sqrt(1 + (1 - kXi * kXi) * r2)) / (1 + r2);
  return {along * m.x(), along * m.y(), along - kXi};
}

std::optional<Place> MirrorCamera::PositionFromDirection(
    const Eigen::Vector3d& direction) const {
  const Eigen::Vector3d seen(direction.x(), direction.y(), direction.z() + kXi);
  if (!(seen.z() > 0.02)) return std::nullopt;
  const Eigen::Vector3d in_camera = mirror_from_camera_.transpose() * seen;
  if (!(in_camera.z() > 0.02)) return std::nullopt;
  return kMirrorFocal * in_camera.head<2>() / in_camera.z();
}

}  // namespace raygrid
