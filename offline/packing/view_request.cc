#include "packing/view_request.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "dataset/error.h"

namespace raygrid {
namespace {

// The field of view that projections may have along x and along y, degrees. An
// image whose projection stretches without bound has little room for the rest
// if it shows more of what is far off.
Eigen::Vector2d LargestFieldDeg(ViewProjection projection) {
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
constexpr double kMostStretchRad = 85 * M_PI / 180;
// Views that are not asked for by an angle show less.
constexpr double kUsefulStretchRad = 70 * M_PI / 180;

// Blobs hold focal lengths and centres in q16.
constexpr double kMaxFocalPx = 65535;
constexpr double kMaxCenterPx = 32767;

[[noreturn]] void ThrowUsage(const std::string& what) {
  throw Error(ExitCode::kUsage, what);
}

// A view of focal length 1 around (0, 0), whose pixels are points of the plane.
VirtualView Plane(const ViewRequest& request) {
  VirtualView plane;
  plane.projection = request.projection.value_or(ViewProjection::kPinhole);
  plane.focal_px = {1, 1};
  if (request.rotate_deg)
    plane.camera_from_view = RotationOfAngles(*request.rotate_deg);
  return plane;
}

// Pixels per radian where the view looks straight ahead, or else where the
// camera does, or in the middle of its area.
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
        projection.by_point * projection.by_point.transpose();
    return std::pow(product.determinant(), 0.25);
  }
  return camera.image_size().width;
}

double Stretch(const VirtualView& plane, const Eigen::Vector3d& ray) {
  return StretchAngle(plane.projection,
                      plane.camera_from_view.transpose() * ray);
}

// A camera's area as a plane shows it.
struct AreaOnPlane {
  Eigen::AlignedBox2d box;  // of what is stretched less than a limit
  double most_stretch_rad = 0;
};

// By the edges, each in as many steps, and a few points within.
AreaOnPlane FindAreaOnPlane(const CameraModel& camera, const VirtualView& plane,
                            double limit_rad, int num_steps) {
  const Area& area = camera.area();
  AreaOnPlane found;
  const auto add = [&](int i, int j) {
    const auto ray =
        camera.Unproject({area.x0 + area.width() * i / num_steps,
                          area.y0 + area.height() * j / num_steps});
    if (!ray) return;
    const double stretch_rad = Stretch(plane, *ray);
    found.most_stretch_rad = std::max(found.most_stretch_rad, stretch_rad);
    const auto point = plane.Pixel(*ray);
    if (point && stretch_rad < limit_rad) found.box.extend(*point);
  };
  for (int k = 0; k <= num_steps; ++k) {
    add(k, 0);
    add(k, num_steps);
    add(0, k);
    add(num_steps, k);
  }
  const int coarse = std::max(1, num_steps / 32);
  for (int j = coarse; j < num_steps; j += coarse)
    for (int i = coarse; i < num_steps; i += coarse) add(i, j);
  return found;
}

// The focal length at which an axis of an image has a field of view.
double FocalOf(ViewProjection projection, int axis, double field_deg,
               double center_px, int pixels) {
  const double from_middle = center_px - (pixels - 1) / 2.0;
  if (std::abs(from_middle) >= pixels / 2.0)
    ThrowUsage(
        fmt::format("{} with a center outside the image; ask for a "
                    "focal length",
                    axis == 0 ? "hfov" : "vfov"));
  if (from_middle == 0 && projection == ViewProjection::kPinhole)
    return pixels / 2.0 / std::tan(field_deg * M_PI / 360);
  double low = 1e-3, high = 1e9;
  for (int k = 0; k < 200; ++k) {
    const double middle = std::sqrt(low * high);
    const double field =
        FieldOfViewDeg(projection, axis, middle, center_px, pixels);
    (field >= field_deg ? low : high) = middle;
  }
  return high;
}

// The view around a plane's point that lies in the middle of the image.
VirtualView ViewOfMiddle(const VirtualView& plane, const ImageSize& size,
                         const Eigen::Vector2d& middle, double focal_px) {
  VirtualView view = plane;
  view.size = size;
  view.focal_px = {focal_px, focal_px};
  view.center_px =
      Eigen::Vector2d(size.width - 1, size.height - 1) / 2 - focal_px * middle;
  return view;
}

// The largest view without border: its focal length is the least at which all
// of its pixels come from the camera's area.
class LargestWithoutBorder {
 public:
  LargestWithoutBorder(const CameraModel& camera, const VirtualView& plane,
                       const ImageSize& size)
      : camera_(camera), plane_(plane), size_(size) {
    // Tables are off by less, unless their bound is larger: they do not lead to
    // the border.
    constexpr double kInsetPx = 0.25;
    const Area& area = camera.area();
    const Area image = WholeImage(camera.image_size());
    inside_ = {std::max(area.x0, image.x0) + kInsetPx,
               std::max(area.y0, image.y0) + kInsetPx,
               std::min(area.x1, image.x1) - kInsetPx,
               std::min(area.y1, image.y1) - kInsetPx};
  }

  VirtualView Find() const {
    const auto ray = camera_.Unproject(inside_.center());
    const auto start = ray ? plane_.Pixel(*ray) : std::nullopt;
    if (!start || !(Stretch(plane_, *ray) < kUsefulStretchRad) ||
        !IsWithoutBorder(At(*start, kMaxFocalPx)))
      ThrowUsage(
          "alpha below 1: the view does not show the middle of the camera's "
          "area; ask for a field of view, or rotate it there");
    Eigen::Vector2d middle = *start;
    double focal_px = Widest(middle, kMaxFocalPx);
    // A search by steps in eight directions, in parts of the half image.
    for (double step = 0.25; step > 1e-3 && focal_px > ShortestPx();) {
      bool is_better = false;
      for (int k = 0; k < 8 && !is_better; ++k) {
        const double part = step * size_.width / 2.0 / focal_px;
        const Eigen::Vector2d next =
            middle + part * Eigen::Vector2d(std::cos(k * M_PI / 4),
                                            std::sin(k * M_PI / 4));
        if (!IsWithoutBorder(At(next, (1 - 1e-4) * focal_px))) continue;
        middle = next;
        focal_px = Widest(next, focal_px);
        is_better = true;
      }
      if (!is_better) step /= 2;
    }
    return At(middle, focal_px);
  }

 private:
  VirtualView At(const Eigen::Vector2d& middle, double focal_px) const {
    return ViewOfMiddle(plane_, size_, middle, focal_px);
  }

  // Wider views, around the axis, show too much of what is far off, or the same
  // twice.
  double ShortestPx() const {
    const double far = std::tan(kUsefulStretchRad);
    const double width = size_.width / 2.0, height = size_.height / 2.0;
    switch (plane_.projection) {
      case ViewProjection::kPinhole:
        return std::max(width, height) / far;
      case ViewProjection::kCylindrical:
        return std::max(width / M_PI, height / far);
      case ViewProjection::kEquirectangular:
        return std::max(width / M_PI, height / (M_PI / 2));
      case ViewProjection::kStereographic:
        return std::max(width, height) / (2 * far);
      case ViewProjection::kEquidistant:
        break;
    }
    return std::hypot(width, height) / M_PI;
  }

  // The least focal length, below one that is too long or long enough.
  double Widest(const Eigen::Vector2d& middle, double long_px) const {
    double least = ShortestPx();
    if (IsWithoutBorder(At(middle, least))) return least;
    double enough = long_px;
    for (int k = 0; k < 40; ++k) {
      const double between = std::sqrt(least * enough);
      (IsWithoutBorder(At(middle, between)) ? enough : least) = between;
    }
    return enough;
  }

  // Asks along the edges, each point from its neighbour's source on, and
  // within.
  bool IsWithoutBorder(const VirtualView& view) const {
    constexpr int kSteps = 64;
    const double right = size_.width - 1, bottom = size_.height - 1;
    const std::array<Eigen::Vector2d, 5> corners = {
        Eigen::Vector2d(0, 0), Eigen::Vector2d(right, 0),
        Eigen::Vector2d(right, bottom), Eigen::Vector2d(0, bottom),
        Eigen::Vector2d(0, 0)};
    std::optional<Eigen::Vector2d> source;
    const auto is_seen = [&](const Eigen::Vector2d& pixel) {
      const Eigen::Vector2d start = source.value_or(inside_.center());
      const auto direction = view.Direction(pixel);
      source =
          direction ? camera_.Project(*direction, &start, 0) : std::nullopt;
      return source && inside_.Contains(*source);
    };
    for (int side = 0; side < 4; ++side)
      for (int k = 0; k < kSteps; ++k)
        if (!is_seen(corners[side] +
                     (corners[side + 1] - corners[side]) * k / kSteps))
          return false;
    for (int j = 1; j < 8; ++j)
      for (int i = 1; i < 8; ++i)
        if (!is_seen({right * i / 8, bottom * j / 8})) return false;
    return true;
  }

  const CameraModel& camera_;
  const VirtualView plane_;
  const ImageSize size_;
  Area inside_;
};

// The smallest view that shows every pixel of the area.
VirtualView SmallestOfAll(const CameraModel& camera, const VirtualView& plane,
                          const ImageSize& size) {
  const AreaOnPlane seen = FindAreaOnPlane(camera, plane, kMostStretchRad, 256);
  if (seen.box.isEmpty() || seen.most_stretch_rad > kMostStretchRad)
    ThrowUsage(fmt::format(
        "alpha above 0: a {} image does not show all of a camera that sees "
        "{:.0f} degrees off its {}; {}",
        ProjectionName(plane.projection),
        (plane.projection == ViewProjection::kStereographic ? 2 : 1) *
            seen.most_stretch_rad * 180 / M_PI,
        plane.projection == ViewProjection::kCylindrical ? "horizon" : "axis",
        "alpha=0, a field of view or projection=equidistant works"));
  // Half a pixel on each side for what lies between the samples.
  const Eigen::Vector2d room(std::max(1, size.width - 2),
                             std::max(1, size.height - 2));
  return ViewOfMiddle(plane, size, seen.box.center(),
                      (room.array() / seen.box.sizes().array()).minCoeff());
}

VirtualView ViewOfAlpha(const CameraModel& camera, const VirtualView& plane,
                        const ImageSize& size, double alpha) {
  if (alpha == 1) return SmallestOfAll(camera, plane, size);
  VirtualView view = LargestWithoutBorder(camera, plane, size).Find();
  if (alpha == 0) return view;
  const VirtualView all = SmallestOfAll(camera, plane, size);
  view.focal_px += alpha * (all.focal_px - view.focal_px);
  view.center_px += alpha * (all.center_px - view.center_px);
  return view;
}

VirtualView Scaled(const VirtualView& view, const ImageSize& size) {
  const Eigen::Array2d scale(
      static_cast<double>(size.width) / view.size.width,
      static_cast<double>(size.height) / view.size.height);
  VirtualView result = view;
  result.size = size;
  result.focal_px = view.focal_px.array() * scale;
  result.center_px = (view.center_px.array() + 0.5) * scale - 0.5;
  return result;
}

// A view around a centre with the focal lengths that are asked for.
VirtualView ViewAround(const CameraModel& camera, const VirtualView& plane,
                       const ViewRequest& request, const ImageSize& size) {
  VirtualView view = plane;
  view.size = size;
  view.center_px = request.center_px.value_or(
      Eigen::Vector2d((size.width - 1) / 2.0, (size.height - 1) / 2.0));
  double fx = 0, fy = 0;
  if (request.focal_px) {
    fx = fy = *request.focal_px;
  } else if (request.hfov_deg || request.vfov_deg) {
    if (request.hfov_deg)
      fx = FocalOf(view.projection, 0, *request.hfov_deg, view.center_px.x(),
                   size.width);
    if (request.vfov_deg)
      fy = FocalOf(view.projection, 1, *request.vfov_deg, view.center_px.y(),
                   size.height);
    if (fx == 0) fx = fy;
    if (fy == 0) fy = fx;
  } else {
    fx = fy = CentralFocalLength(camera, plane) * size.width /
              camera.image_size().width;
  }
  view.focal_px = {fx, fy};
  return view;
}

void RequireThatBlobsHold(const VirtualView& view) {
  const double focal_px = view.focal_px.maxCoeff();
  if (!(focal_px <= kMaxFocalPx))
    ThrowUsage(fmt::format(
        "a focal length of {:.0f} px for {} px of width: a blob holds at most "
        "{}; ask for a field of view of at least {:.3g} degrees, or for fewer "
        "pixels",
        focal_px, view.size.width, kMaxFocalPx,
        std::atan(view.size.width / 2.0 / kMaxFocalPx) * 360 / M_PI + 0.001));
  if (!(view.center_px.cwiseAbs().maxCoeff() <= kMaxCenterPx))
    ThrowUsage(fmt::format(
        "a center at ({:.0f}, {:.0f}): a blob holds at most {} px; ask for one "
        "nearer to the image",
        view.center_px.x(), view.center_px.y(), kMaxCenterPx));
}

void RequireField(const char* name, ViewProjection projection,
                  const std::optional<double>& field_deg, double most_deg) {
  if (!field_deg || (*field_deg > 0 && *field_deg <= most_deg)) return;
  ThrowUsage(
      fmt::format("{} of {} degrees: a {} image has a field of view of more "
                  "than 0 and at most {}",
                  name, *field_deg, ProjectionName(projection), most_deg));
}

}  // namespace

void RequireSensible(const ViewRequest& request) {
  const int num_ways = (request.hfov_deg || request.vfov_deg) +
                       request.focal_px.has_value() +
                       request.alpha.has_value() + request.like.has_value();
  if (num_ways > 1)
    ThrowUsage(
        "a view by several of hfov and vfov, focal, alpha, like; give one");
  if (request.center_px && (request.alpha || request.like))
    ThrowUsage(
        "a view by center and by alpha or like, which have their own; "
        "give one");
  if (request.like && (request.projection || request.rotate_deg))
    ThrowUsage(
        "a view by like and by projection or rotate, which like has; give one");
  const ViewProjection projection =
      request.projection.value_or(ViewProjection::kPinhole);
  const Eigen::Vector2d most_deg = LargestFieldDeg(projection);
  RequireField("hfov", projection, request.hfov_deg, most_deg.x());
  RequireField("vfov", projection, request.vfov_deg, most_deg.y());
  if (request.focal_px && !(*request.focal_px > 0))
    ThrowUsage(
        fmt::format("a focal length of {}: it is above 0", *request.focal_px));
  if (request.alpha && (!(*request.alpha >= 0) || !(*request.alpha <= 1)))
    ThrowUsage(fmt::format(
        "alpha of {}: 0 is the largest view without border, 1 the smallest "
        "that shows all, and others are between",
        *request.alpha));
}

VirtualView MakeView(const CameraModel& camera, const ViewRequest& request) {
  RequireSensible(request);
  const ImageSize size = request.size.width != 0 ? request.size
                         : request.like          ? request.like->size
                                                 : camera.image_size();
  const VirtualView plane = Plane(request);
  const VirtualView view =
      request.alpha  ? ViewOfAlpha(camera, plane, size, *request.alpha)
      : request.like ? Scaled(*request.like, size)
                     : ViewAround(camera, plane, request, size);
  RequireThatBlobsHold(view);
  return view;
}

VirtualView MakeViewOfMode(const CameraModel& camera, const SensorMode& mode,
                           const ViewRequest& request) {
  const ModeCamera frames(camera, mode);
  VirtualView view = MakeView(frames, request);
  if (request.center_px || request.alpha || request.like || request.rotate_deg)
    return view;
  const ImageSize& size = camera.image_size();
  const auto calibrated_middle = camera.Unproject(WholeImage(size).center());
  const auto middle =
      camera.Unproject(mode.ToCalibrated(WholeImage(mode.size).center()));
  if (!calibrated_middle || !middle) return view;
  const Eigen::Vector2d center_px = view.center_px;
  // A field of view around another centre has another focal length.
  constexpr int kTurns = 5;
  ViewRequest moved = request;
  for (int turn = 0; turn < kTurns; ++turn) {
    const auto from = view.Pixel(*middle), to = view.Pixel(*calibrated_middle);
    if (!from || !to) return MakeView(frames, request);
    moved.center_px = center_px + *to - *from;
    view = MakeView(frames, moved);
  }
  return view;
}

VirtualView MakeViewOfArea(const CameraModel& camera) {
  const VirtualView plane = Plane({});
  const AreaOnPlane seen =
      FindAreaOnPlane(camera, plane, kUsefulStretchRad, 32);
  const ImageSize& size = camera.image_size();
  if (!seen.box.isEmpty()) {
    const double focal_px =
        (Eigen::Array2d(size.width, size.height) / seen.box.sizes().array())
            .minCoeff();
    const VirtualView view =
        ViewOfMiddle(plane, size, seen.box.center(), focal_px);
    if (focal_px <= kMaxFocalPx &&
        view.center_px.cwiseAbs().maxCoeff() <= kMaxCenterPx)
      return view;
  }
  throw Error(ExitCode::kQuality, "no pinhole image shows the calibrated area");
}

}  // namespace raygrid
