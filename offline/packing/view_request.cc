#include "packing/view_request.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "dataset/error.h"
#include "packing/alpha_view.h"

namespace raygrid {
namespace {

// Returns the maximum field of view of projections along x and y, in degrees.
// For projections with unbounded stretch, a larger one would compress the
// centre.
Eigen::Vector2d GetMaxFieldDeg(ViewProjection projection) {
  switch (projection) {
    case ViewProjection::kPinhole:
      return {170, 170};
    case ViewProjection::kCylindrical:
      return {360, 170};
    case ViewProjection::kEquirectangular:
      return {360, 180};
    case ViewProjection::kStereographic:
      return {340, 340};
    case ViewProjection::kEquidistant:
      break;
  }
  return {360, 360};
}

// Blobs store principal points in q16.
constexpr double kMaxCenterPx = 32767;

[[noreturn]] void ThrowUsage(const std::string& what) {
  throw Error(ExitCode::kUsage, what);
}

// Returns a view of focal length 1 with principal point (0, 0): its pixels are
// points of the image plane.
VirtualView Plane(const ViewRequest& request) {
  VirtualView plane;
  plane.projection = request.projection.value_or(ViewProjection::kPinhole);
  plane.focal_px = {1, 1};
  if (request.rotate_deg)
    plane.camera_from_view = RotationFromAngles(*request.rotate_deg);
  return plane;
}

// Returns the number of pixels per radian at the view's principal point,
// otherwise at the camera's, or at the centre of its area.
double CentralFocalLength(const CameraModel& camera, const VirtualView& plane) {
  LinearizedProjection projection;
  const auto ray = camera.Unproject(camera.area().center());
  const std::array<std::optional<Eigen::Vector3d>, 3> directions = {
      Eigen::Vector3d(plane.camera_from_view.col(2)), Eigen::Vector3d(0, 0, 1),
      ray};
  for (const auto& direction : directions) {
    if (!direction || !camera.Linearize(*direction, nullptr, 0, &projection))
      continue;
    // The two singular values' geometric mean.
    const Eigen::Matrix2d product =
        projection.J_point * projection.J_point.transpose();
    return std::pow(product.determinant(), 0.25);
  }
  return camera.image_size().width;
}

// Returns the focal length that yields a field of view along an axis of an
// image.
double SolveFocalLength(ViewProjection projection, int axis, double field_deg,
                        double center_px, int pixels) {
  const double from_center = center_px - (pixels - 1) / 2.0;
  if (std::abs(from_center) >= pixels / 2.0)
    ThrowUsage(fmt::format(
        "{} cannot be used with a center outside the image; use a focal length",
        axis == 0 ? "hfov" : "vfov"));
  if (from_center == 0 && projection == ViewProjection::kPinhole)
    return pixels / 2.0 / std::tan(field_deg * M_PI / 360);
  double low = 1e-3, high = 1e9;
  for (int k = 0; k < 200; ++k) {
    const double midpoint = std::sqrt(low * high);
    const double field =
        ComputeFieldOfViewDeg(projection, axis, midpoint, center_px, pixels);
    (field >= field_deg ? low : high) = midpoint;
  }
  return high;
}

VirtualView FindEnclosingViewOrThrow(const CameraAndPlane& seen,
                                     const ImageSize& size) {
  const EnclosingView all = FindSmallestEnclosingView({seen}, size);
  if (all.view) return *all.view;
  const ViewProjection projection = seen.plane.projection;
  ThrowUsage(fmt::format(
      "alpha above 0: a {} view cannot contain all pixels, which extend up to "
      "{:.0f} degrees off its {}; {}",
      ProjectionName(projection),
      (projection == ViewProjection::kStereographic ? 2 : 1) *
          all.max_stretch_rad * 180 / M_PI,
      projection == ViewProjection::kCylindrical ? "horizon" : "axis",
      "use alpha=0, a field of view or projection=equidistant"));
}

VirtualView MakeAlphaView(const CameraModel& camera, const VirtualView& plane,
                          const ImageSize& size, double alpha) {
  const CameraAndPlane seen = {camera, plane};
  if (alpha == 1) return FindEnclosingViewOrThrow(seen, size);
  const auto largest = FindLargestViewWithoutBorder({seen}, size);
  if (!largest)
    ThrowUsage(
        "alpha below 1: the output view does not contain the centre of the "
        "calibrated area; set a field of view, or rotate the view");
  if (alpha == 0) return *largest;
  return InterpolateViews(*largest, FindEnclosingViewOrThrow(seen, size),
                          alpha);
}

VirtualView ScaleView(const VirtualView& view, const ImageSize& size) {
  const Eigen::Array2d scale(
      static_cast<double>(size.width) / view.size.width,
      static_cast<double>(size.height) / view.size.height);
  VirtualView result = view;
  result.size = size;
  result.focal_px = view.focal_px.array() * scale;
  result.center_px = (view.center_px.array() + 0.5) * scale - 0.5;
  return result;
}

// Returns a view about a principal point with the requested focal lengths; they
// are 0 if none is requested.
VirtualView MakeViewAround(const VirtualView& plane, const ViewRequest& request,
                           const ImageSize& size) {
  VirtualView view = plane;
  view.size = size;
  view.center_px = request.center_px.value_or(
      Eigen::Vector2d((size.width - 1) / 2.0, (size.height - 1) / 2.0));
  double fx = 0, fy = 0;
  if (request.focal_px) {
    fx = fy = *request.focal_px;
  } else if (request.hfov_deg || request.vfov_deg) {
    if (request.hfov_deg)
      fx = SolveFocalLength(view.projection, 0, *request.hfov_deg,
                            view.center_px.x(), size.width);
    if (request.vfov_deg)
      fy = SolveFocalLength(view.projection, 1, *request.vfov_deg,
                            view.center_px.y(), size.height);
    if (fx == 0) fx = fy;
    if (fy == 0) fy = fx;
  }
  view.focal_px = {fx, fy};
  return view;
}

// Like MakeViewAround(), but with the camera's resolution if no focal length is
// requested.
VirtualView MakeViewOfSameResolution(const CameraModel& camera,
                                     const VirtualView& plane,
                                     const ViewRequest& request,
                                     const ImageSize& size) {
  VirtualView view = MakeViewAround(plane, request, size);
  if (view.focal_px.x() == 0)
    view.focal_px.setConstant(CentralFocalLength(camera, plane) * size.width /
                              camera.image_size().width);
  return view;
}

void RequireField(const char* name, ViewProjection projection,
                  const std::optional<double>& field_deg, double max_deg) {
  if (!field_deg || (*field_deg > 0 && *field_deg <= max_deg)) return;
  ThrowUsage(
      fmt::format("{0} of {1} degrees: the field of view of a {2} view must be "
                  "above 0 and at most {3}",
                  name, *field_deg, ProjectionName(projection), max_deg));
}

}  // namespace

void RequireValidView(const ViewRequest& request) {
  const int num_ways = (request.hfov_deg || request.vfov_deg) +
                       request.focal_px.has_value() +
                       request.alpha.has_value() + request.like.has_value();
  if (num_ways > 1)
    ThrowUsage(
        "hfov or vfov, focal, alpha and view are mutually exclusive; specify "
        "one of them");
  if (request.center_px && (request.alpha || request.like))
    ThrowUsage("center cannot be combined with alpha or view");
  if (request.like && (request.projection || request.rotate_deg))
    ThrowUsage("view cannot be combined with projection or rotate");
  const ViewProjection projection =
      request.projection.value_or(ViewProjection::kPinhole);
  const Eigen::Vector2d max_deg = GetMaxFieldDeg(projection);
  RequireField("hfov", projection, request.hfov_deg, max_deg.x());
  RequireField("vfov", projection, request.vfov_deg, max_deg.y());
  if (request.focal_px && !(*request.focal_px > 0))
    ThrowUsage(
        fmt::format("focal length of {}: must be positive", *request.focal_px));
  if (request.alpha && (!(*request.alpha >= 0) || !(*request.alpha <= 1)))
    ThrowUsage(
        fmt::format("alpha {}: must be 0 (largest view without border) to 1 "
                    "(smallest view of all pixels)",
                    *request.alpha));
}

void RequirePackableView(const VirtualView& view) {
  const double focal_px = view.focal_px.maxCoeff();
  if (!(focal_px <= kMaxFocalPx))
    ThrowUsage(fmt::format(
        "a focal length of {:.0f} px for {} px of width exceeds the limit of "
        "{}; use a field of view of at least {:.3g} degrees, or a smaller size",
        focal_px, view.size.width, kMaxFocalPx,
        std::atan(view.size.width / 2.0 / kMaxFocalPx) * 360 / M_PI + 0.001));
  if (!(view.center_px.cwiseAbs().maxCoeff() <= kMaxCenterPx))
    ThrowUsage(
        fmt::format("a center at ({:.0f}, {:.0f}) exceeds the limit of {} px",
                    view.center_px.x(), view.center_px.y(), kMaxCenterPx));
}

VirtualView MakeView(const CameraModel& camera, const ViewRequest& request) {
  RequireValidView(request);
  const ImageSize size = request.size.width != 0 ? request.size
                         : request.like          ? request.like->size
                                                 : camera.image_size();
  const VirtualView plane = Plane(request);
  const VirtualView view =
      request.alpha  ? MakeAlphaView(camera, plane, size, *request.alpha)
      : request.like ? ScaleView(*request.like, size)
                     : MakeViewOfSameResolution(camera, plane, request, size);
  RequirePackableView(view);
  return view;
}

VirtualView MakeViewWithoutCamera(const ImageSize& size,
                                  const ViewRequest& request) {
  RequireValidView(request);
  if (request.alpha) ThrowUsage("alpha requires the camera; use view instead");
  const VirtualView view = request.like
                               ? ScaleView(*request.like, size)
                               : MakeViewAround(Plane(request), request, size);
  if (view.focal_px.x() == 0)
    ThrowUsage("missing field of view; specify hfov, vfov, focal or view");
  RequirePackableView(view);
  return view;
}

VirtualView MakeModeView(const CameraModel& camera, const SensorMode& mode,
                         const ViewRequest& request) {
  const ModeCamera frames(camera, mode);
  VirtualView view = MakeView(frames, request);
  if (request.center_px || request.alpha || request.like || request.rotate_deg)
    return view;
  const ImageSize& size = camera.image_size();
  const auto calibrated_center_px = camera.Unproject(WholeImage(size).center());
  const auto midpoint =
      camera.Unproject(mode.ToCalibrated(WholeImage(mode.size).center()));
  if (!calibrated_center_px || !midpoint) return view;
  const Eigen::Vector2d center_px = view.center_px;
  // Iterates, since moving the principal point changes the focal length for a
  // given field of view.
  constexpr int kMaxIterations = 5;
  ViewRequest moved = request;
  for (int turn = 0; turn < kMaxIterations; ++turn) {
    const auto from = view.Pixel(*midpoint),
               to = view.Pixel(*calibrated_center_px);
    if (!from || !to) return MakeView(frames, request);
    moved.center_px = center_px + *to - *from;
    view = MakeView(frames, moved);
  }
  return view;
}

VirtualView MakeAreaView(const CameraModel& camera) {
  const VirtualView plane = Plane({});
  const AreaOnPlane seen =
      FindAreaOnPlane({camera, plane}, kDefaultMaxStretchRad, 32);
  const ImageSize& size = camera.image_size();
  if (!seen.box.isEmpty()) {
    const double focal_px =
        (Eigen::Array2d(size.width, size.height) / seen.box.sizes().array())
            .minCoeff();
    const VirtualView view =
        MakeCentralView(plane, size, seen.box.center(), focal_px);
    if (focal_px <= kMaxFocalPx &&
        view.center_px.cwiseAbs().maxCoeff() <= kMaxCenterPx)
      return view;
  }
  throw Error(ExitCode::kQualityTooLow,
              "no pinhole view contains the calibrated area");
}

}  // namespace raygrid
