#include "packing/view.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "camera/opencv.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

constexpr double kMaxFieldOfViewDeg = 170;
// A pinhole image that shows more of what is off the axis has little room for
// the rest.
constexpr double kFarOffDeg = 70;
// Blobs hold focal lengths and centres in q16.
constexpr double kMaxFocalPx = 65535;
constexpr double kMaxCenterPx = 32767;

// Pixels per radian where the camera looks straight ahead, or else in the
// middle of its area.
double CentralFocalLength(const CameraModel& camera) {
  LinearizedProjection projection;
  const Eigen::Vector3d forward(0, 0, 1);
  if (!camera.Linearize(forward, nullptr, 0, &projection)) {
    const auto ray = camera.Unproject(camera.area().center());
    if (!ray || !camera.Linearize(*ray, nullptr, 0, &projection))
      return camera.image_size().width;
  }
  // The two singular values' geometric mean.
  const Eigen::Matrix2d product =
      projection.by_point * projection.by_point.transpose();
  return std::pow(product.determinant(), 0.25);
}

// The box in which a pinhole image of focal length 1 shows the area, as far as
// it does.
Eigen::AlignedBox2d ImageOfArea(const CameraModel& camera) {
  constexpr int kSteps = 32;
  const double least_z = std::cos(kFarOffDeg * M_PI / 180);
  Eigen::AlignedBox2d box;
  const Area& area = camera.area();
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const auto ray = camera.Unproject({area.x0 + area.width() * i / kSteps,
                                         area.y0 + area.height() * j / kSteps});
      if (ray && ray->z() > least_z)
        box.extend(Eigen::Vector2d(ray->head<2>() / ray->z()));
    }
  }
  return box;
}

[[noreturn]] void ThrowUsage(const std::string& what) {
  throw Error(ExitCode::kUsage, what);
}

// The angle between the outer edges of `pixels` pixels, degrees.
double FieldOfViewDeg(double focal_px, double center_px, int pixels) {
  return (std::atan((center_px + 0.5) / focal_px) +
          std::atan((pixels - 0.5 - center_px) / focal_px)) *
         180 / M_PI;
}

// The focal length at which an image has a field of view.
double FocalOf(const char* name, double field_deg, double center_px,
               int pixels) {
  if (!(field_deg > 0) || !(field_deg <= kMaxFieldOfViewDeg))
    ThrowUsage(
        fmt::format("{} of {} degrees: a pinhole image has a field of "
                    "view of more than 0 and at most {}",
                    name, field_deg, kMaxFieldOfViewDeg));
  const double from_middle = center_px - (pixels - 1) / 2.0;
  if (from_middle == 0) return pixels / 2.0 / std::tan(field_deg * M_PI / 360);
  if (std::abs(from_middle) >= pixels / 2.0)
    ThrowUsage(
        fmt::format("{} with a center outside the image; ask for a "
                    "focal length",
                    name));
  double low = 1e-3, high = 1e9;
  for (int k = 0; k < 200; ++k) {
    const double middle = std::sqrt(low * high);
    (FieldOfViewDeg(middle, center_px, pixels) > field_deg ? low : high) =
        middle;
  }
  return high;
}

// The largest view without border: its focal length is the least at which all
// of its pixels come from the camera's area.
class LargestWithoutBorder {
 public:
  LargestWithoutBorder(const CameraModel& camera, const ImageSize& size)
      : camera_(camera), size_(size) {
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
    if (!ray || !(ray->z() > std::cos(kFarOffDeg * M_PI / 180)))
      ThrowUsage(
          "alpha=0: the camera's area lies too far to the side for a pinhole "
          "image; ask for a field of view");
    Eigen::Vector2d middle = ray->head<2>() / ray->z();
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
  // The view whose middle shows this point of the plane at z = 1.
  VirtualView At(const Eigen::Vector2d& middle, double focal_px) const {
    VirtualView view;
    view.size = size_;
    view.focal_px = {focal_px, focal_px};
    view.center_px = Eigen::Vector2d(size_.width - 1, size_.height - 1) / 2 -
                     focal_px * middle;
    return view;
  }

  // Wider views show too much of what is far off the axis.
  double ShortestPx() const {
    return std::max(size_.width, size_.height) / 2.0 /
           std::tan(kFarOffDeg * M_PI / 180);
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
      source = camera_.Project(view.Direction(pixel), &start, 0);
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
  const ImageSize size_;
  Area inside_;
};

// The smallest view that shows every pixel of the area.
VirtualView SmallestOfAll(const CameraModel& camera, const ImageSize& size) {
  constexpr int kSteps = 256;
  const double least_z = std::cos(kMaxFieldOfViewDeg * M_PI / 360);
  const Area& area = camera.area();
  Eigen::AlignedBox2d box;
  double widest_rad = 0;
  const auto add = [&](double x, double y) {
    const auto ray = camera.Unproject({area.x0 + area.width() * x / kSteps,
                                       area.y0 + area.height() * y / kSteps});
    if (!ray) return;
    widest_rad =
        std::max(widest_rad, std::atan2(ray->head<2>().norm(), ray->z()));
    if (ray->z() > least_z)
      box.extend(Eigen::Vector2d(ray->head<2>() / ray->z()));
  };
  for (int k = 0; k <= kSteps; ++k) {
    add(k, 0);
    add(k, kSteps);
    add(0, k);
    add(kSteps, k);
  }
  for (int j = 8; j < kSteps; j += 8)
    for (int i = 8; i < kSteps; i += 8) add(i, j);
  if (box.isEmpty() || widest_rad > kMaxFieldOfViewDeg * M_PI / 360)
    ThrowUsage(
        fmt::format("alpha above 0: no pinhole image shows all of a camera "
                    "that sees {:.0f} "
                    "degrees off its axis; alpha=0 or a field of view works",
                    widest_rad * 180 / M_PI));
  // Half a pixel on each side for what lies between the samples.
  const Eigen::Vector2d room(std::max(1, size.width - 2),
                             std::max(1, size.height - 2));
  const double focal_px = (room.array() / box.sizes().array()).minCoeff();
  VirtualView view;
  view.size = size;
  view.focal_px = {focal_px, focal_px};
  view.center_px = Eigen::Vector2d(size.width - 1, size.height - 1) / 2 -
                   focal_px * box.center();
  return view;
}

VirtualView ViewOfAlpha(const CameraModel& camera, const ImageSize& size,
                        double alpha) {
  if (!(alpha >= 0) || !(alpha <= 1))
    ThrowUsage(fmt::format(
        "alpha of {}: 0 is the largest view without border, 1 the smallest "
        "that shows all, and others are between",
        alpha));
  if (alpha == 1) return SmallestOfAll(camera, size);
  VirtualView view = LargestWithoutBorder(camera, size).Find();
  if (alpha == 0) return view;
  const VirtualView all = SmallestOfAll(camera, size);
  view.focal_px += alpha * (all.focal_px - view.focal_px);
  view.center_px += alpha * (all.center_px - view.center_px);
  return view;
}

VirtualView Scaled(const VirtualView& view, const ImageSize& size) {
  const Eigen::Array2d scale(
      static_cast<double>(size.width) / view.size.width,
      static_cast<double>(size.height) / view.size.height);
  VirtualView result;
  result.size = size;
  result.focal_px = view.focal_px.array() * scale;
  result.center_px = (view.center_px.array() + 0.5) * scale - 0.5;
  return result;
}

// A view around a centre with the focal lengths that are asked for.
VirtualView ViewAround(const CameraModel& camera, const ViewRequest& request,
                       const ImageSize& size) {
  VirtualView view;
  view.size = size;
  view.center_px = request.center_px.value_or(
      Eigen::Vector2d((size.width - 1) / 2.0, (size.height - 1) / 2.0));
  double fx = 0, fy = 0;
  if (request.focal_px) {
    fx = fy = *request.focal_px;
    if (!(fx > 0))
      ThrowUsage(fmt::format("a focal length of {}: it is above 0", fx));
  } else if (request.hfov_deg || request.vfov_deg) {
    if (request.hfov_deg)
      fx = FocalOf("hfov", *request.hfov_deg, view.center_px.x(), size.width);
    if (request.vfov_deg)
      fy = FocalOf("vfov", *request.vfov_deg, view.center_px.y(), size.height);
    if (fx == 0) fx = fy;
    if (fy == 0) fy = fx;
  } else {
    fx = fy =
        CentralFocalLength(camera) * size.width / camera.image_size().width;
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

}  // namespace

std::optional<Eigen::Vector2d> VirtualView::Pixel(
    const Eigen::Vector3d& direction) const {
  if (!(direction.z() > 0)) return std::nullopt;
  return Eigen::Vector2d(
      focal_px.x() * direction.x() / direction.z() + center_px.x(),
      focal_px.y() * direction.y() / direction.z() + center_px.y());
}

double VirtualView::HorizontalFieldOfViewDeg() const {
  return FieldOfViewDeg(focal_px.x(), center_px.x(), size.width);
}

double VirtualView::VerticalFieldOfViewDeg() const {
  return FieldOfViewDeg(focal_px.y(), center_px.y(), size.height);
}

VirtualView MakeView(const CameraModel& camera, const ViewRequest& request) {
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
  const ImageSize size = request.size.width != 0 ? request.size
                         : request.like          ? request.like->size
                                                 : camera.image_size();
  const VirtualView view = request.alpha
                               ? ViewOfAlpha(camera, size, *request.alpha)
                           : request.like ? Scaled(*request.like, size)
                                          : ViewAround(camera, request, size);
  RequireThatBlobsHold(view);
  return view;
}

std::unique_ptr<CameraModel> CameraOfView(const VirtualView& view) {
  OpenCvModel::ParameterArray parameters = {};
  parameters[OpenCvModel::kFx] = view.focal_px.x();
  parameters[OpenCvModel::kFy] = view.focal_px.y();
  parameters[OpenCvModel::kCx] = view.center_px.x();
  parameters[OpenCvModel::kCy] = view.center_px.y();
  return std::make_unique<OpenCvModel>(view.size, WholeImage(view.size),
                                       parameters);
}

std::optional<VirtualView> ViewOfCamera(const CameraModel& camera) {
  if (camera.Name() != "opencv") return std::nullopt;
  const Eigen::VectorXd parameters = camera.Parameters();
  if (!parameters.tail(OpenCvModel::kCount - OpenCvModel::kK1).isZero(0))
    return std::nullopt;
  VirtualView view;
  view.size = camera.image_size();
  view.focal_px = {parameters[OpenCvModel::kFx], parameters[OpenCvModel::kFy]};
  view.center_px = {parameters[OpenCvModel::kCx], parameters[OpenCvModel::kCy]};
  return view;
}

VirtualView MakeViewOfArea(const CameraModel& camera) {
  const Eigen::AlignedBox2d seen = ImageOfArea(camera);
  VirtualView result;
  result.size = camera.image_size();
  const Eigen::Vector2d size(result.size.width, result.size.height);
  if (!seen.isEmpty()) {
    const double focal_px = (size.array() / seen.sizes().array()).minCoeff();
    result.focal_px = {focal_px, focal_px};
    result.center_px =
        (size.array() - 1).matrix() / 2 - focal_px * seen.center();
  }
  if (seen.isEmpty() || !(result.focal_px.x() <= kMaxFocalPx) ||
      !(result.center_px.cwiseAbs().maxCoeff() <= kMaxCenterPx))
    throw Error(ExitCode::kQuality,
                "no pinhole image shows the calibrated area");
  return result;
}

}  // namespace raygrid
