#include "packing/alpha_view.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace raygrid {
namespace {

// The usable pixels of a camera, which remap tables may show.
struct UsablePixels {
  Area area;
  std::optional<ImageCircle> circle;

  bool IsValid(const Eigen::Vector2d& pixel) const {
    return area.Contains(pixel) && (!circle || circle->Contains(pixel));
  }
};

UsablePixels SampleUsablePixels(const CameraModel& camera) {
  // Keeps sources off the border: the errors of tables are smaller, unless the
  // limit is larger.
  constexpr double kBorderInsetPx = 0.25;
  const Area& area = camera.area();
  const Area image = WholeImage(camera.image_size());
  UsablePixels inside = {{std::max(area.x0, image.x0) + kBorderInsetPx,
                          std::max(area.y0, image.y0) + kBorderInsetPx,
                          std::min(area.x1, image.x1) - kBorderInsetPx,
                          std::min(area.y1, image.y1) - kBorderInsetPx},
                         camera.image_circle()};
  if (inside.circle) inside.circle->radii_px.array() -= kBorderInsetPx;
  return inside;
}

class BorderlessSearch {
 public:
  BorderlessSearch(const std::vector<CameraAndPlane>& cameras,
                   const ImageSize& size)
      : cameras_(cameras), size_(size) {
    for (const CameraAndPlane& seen : cameras)
      usable_pixels_.push_back(SampleUsablePixels(seen.camera));
  }

  std::optional<VirtualView> Find() const {
    const auto start = Start();
    if (!start) return std::nullopt;
    Eigen::Vector2d center = *start;
    double focal_px = FindMinFocalPx(center, kMaxFocalPx);
    // Pattern search in eight directions, with steps relative to half the
    // image.
    for (double step = 0.25; step > 1e-3 && focal_px > ComputeMinFocalPx();) {
      bool is_better = false;
      for (int k = 0; k < 8 && !is_better; ++k) {
        const double step_radius = step * size_.width / 2.0 / focal_px;
        const Eigen::Vector2d next =
            center + step_radius * Eigen::Vector2d(std::cos(k * M_PI / 4),
                                                   std::sin(k * M_PI / 4));
        if (!HasNoBorder(next, (1 - 1e-4) * focal_px)) continue;
        center = next;
        focal_px = FindMinFocalPx(next, focal_px);
        is_better = true;
      }
      if (!is_better) step /= 2;
    }
    return At(0, center, focal_px);
  }

 private:
  VirtualView At(size_t camera, const Eigen::Vector2d& center,
                 double focal_px) const {
    return MakeCentralView(cameras_[camera].plane, size_, center, focal_px);
  }

  // Returns the mean of the directions of the areas' centres; for several
  // cameras, if necessary, another point inside all areas.
  std::optional<Eigen::Vector2d> Start() const {
    Eigen::Vector2d sum(0, 0);
    Eigen::AlignedBox2d common(Eigen::Vector2d::Constant(-1e9),
                               Eigen::Vector2d::Constant(1e9));
    for (size_t c = 0; c < cameras_.size(); ++c) {
      const auto& [camera, plane] = cameras_[c];
      const auto ray = camera.Unproject(usable_pixels_[c].area.center());
      const auto point = ray ? plane.Pixel(*ray) : std::nullopt;
      if (!point || !(Stretch(plane, *ray) < kDefaultMaxStretchRad))
        return std::nullopt;
      sum += *point;
      common = common.intersection(
          FindAreaOnPlane(cameras_[c], kDefaultMaxStretchRad, 32).box);
    }
    const Eigen::Vector2d mean = sum / static_cast<double>(cameras_.size());
    if (HasNoBorder(mean, kMaxFocalPx)) return mean;
    if (cameras_.size() < 2 || common.isEmpty()) return std::nullopt;
    constexpr int kSteps = 16;
    for (int k = 0; k < kSteps * kSteps; ++k) {
      const Eigen::Vector2d step_radius((k % kSteps + 0.5) / kSteps,
                                        (k / kSteps + 0.5) / kSteps);
      const Eigen::Vector2d point =
          common.min() + step_radius.cwiseProduct(common.sizes());
      if (HasNoBorder(point, kMaxFocalPx)) return point;
    }
    return std::nullopt;
  }

  // Limits the field of view: wider views would show mostly the region far off
  // the axis, or repetitions.
  double ComputeMinFocalPx() const {
    const double far = std::tan(kDefaultMaxStretchRad);
    const double width = size_.width / 2.0, height = size_.height / 2.0;
    switch (cameras_.front().plane.projection) {
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

  // Returns the minimum focal length without border, at most max_focal_px.
  double FindMinFocalPx(const Eigen::Vector2d& center,
                        double max_focal_px) const {
    double least = ComputeMinFocalPx();
    if (HasNoBorder(center, least)) return least;
    double upper_focal_px = max_focal_px;
    for (int k = 0; k < 40; ++k) {
      const double between = std::sqrt(least * upper_focal_px);
      (HasNoBorder(center, between) ? upper_focal_px : least) = between;
    }
    return upper_focal_px;
  }

  bool HasNoBorder(const Eigen::Vector2d& center, double focal_px) const {
    for (size_t c = 0; c < cameras_.size(); ++c)
      if (!HasNoBorder(c, At(c, center, focal_px))) return false;
    return true;
  }

  // Whether the view has no border. Evaluates points along the edges, each
  // initialized with its neighbour's source, and some interior points.
  bool HasNoBorder(size_t c, const VirtualView& view) const {
    constexpr int kSteps = 64;
    const double right = size_.width - 1, bottom = size_.height - 1;
    const std::array<Eigen::Vector2d, 5> corners = {
        Eigen::Vector2d(0, 0), Eigen::Vector2d(right, 0),
        Eigen::Vector2d(right, bottom), Eigen::Vector2d(0, bottom),
        Eigen::Vector2d(0, 0)};
    std::optional<Eigen::Vector2d> source;
    const auto is_seen = [&](const Eigen::Vector2d& pixel) {
      const Eigen::Vector2d start =
          source.value_or(usable_pixels_[c].area.center());
      const auto direction = view.Direction(pixel);
      source = direction ? cameras_[c].camera.Project(*direction, &start, 0)
                         : std::nullopt;
      return source && usable_pixels_[c].IsValid(*source);
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

  const std::vector<CameraAndPlane>& cameras_;
  const ImageSize size_;
  std::vector<UsablePixels> usable_pixels_;
};

}  // namespace

double Stretch(const VirtualView& plane, const Eigen::Vector3d& ray) {
  return StretchAngle(plane.projection,
                      plane.camera_from_view.transpose() * ray);
}

AreaOnPlane FindAreaOnPlane(const CameraAndPlane& seen, double limit_rad,
                            int num_steps) {
  const auto& [camera, plane] = seen;
  const Area& area = camera.area();
  AreaOnPlane found;
  const auto add_pixel = [&, &camera = camera,
                          &plane = plane](const Eigen::Vector2d& pixel) {
    const auto ray = camera.Unproject(pixel);
    if (!ray) return;
    const double stretch_rad = Stretch(plane, *ray);
    found.max_stretch_rad = std::max(found.max_stretch_rad, stretch_rad);
    const auto point = plane.Pixel(*ray);
    if (point && stretch_rad < limit_rad) found.box.extend(*point);
  };
  const auto add = [&, &camera = camera](int i, int j) {
    const Eigen::Vector2d pixel(area.x0 + area.width() * i / num_steps,
                                area.y0 + area.height() * j / num_steps);
    if (camera.IsInImageCircle(pixel)) add_pixel(pixel);
  };
  if (const auto& circle = camera.image_circle())
    for (int k = 0; k < 4 * num_steps; ++k)
      add_pixel(circle->At(k * M_PI / 2 / num_steps));
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

VirtualView MakeCentralView(const VirtualView& plane, const ImageSize& size,
                            const Eigen::Vector2d& center, double focal_px) {
  VirtualView view = plane;
  view.size = size;
  view.focal_px = {focal_px, focal_px};
  view.center_px =
      Eigen::Vector2d(size.width - 1, size.height - 1) / 2 - focal_px * center;
  return view;
}

std::optional<VirtualView> FindLargestViewWithoutBorder(
    const std::vector<CameraAndPlane>& cameras, const ImageSize& size) {
  return BorderlessSearch(cameras, size).Find();
}

EnclosingView FindSmallestEnclosingView(
    const std::vector<CameraAndPlane>& cameras, const ImageSize& size) {
  EnclosingView all;
  Eigen::AlignedBox2d box;
  for (const CameraAndPlane& seen : cameras) {
    const AreaOnPlane area = FindAreaOnPlane(seen, kMaxStretchRad, 256);
    all.max_stretch_rad = std::max(all.max_stretch_rad, area.max_stretch_rad);
    box.extend(area.box);
  }
  if (box.isEmpty() || all.max_stretch_rad > kMaxStretchRad) return all;
  // A margin of half a pixel for positions between the samples.
  const Eigen::Vector2d room(std::max(1, size.width - 2),
                             std::max(1, size.height - 2));
  all.view = MakeCentralView(cameras.front().plane, size, box.center(),
                             (room.array() / box.sizes().array()).minCoeff());
  return all;
}

VirtualView InterpolateViews(const VirtualView& at_0, const VirtualView& at_1,
                             double alpha) {
  VirtualView view = at_0;
  view.focal_px += alpha * (at_1.focal_px - view.focal_px);
  view.center_px += alpha * (at_1.center_px - view.center_px);
  return view;
}

}  // namespace raygrid
