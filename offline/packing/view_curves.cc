#include "packing/view_curves.h"

#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

// Splits points into curves, which end at missing points, or if the distance to
// the previous point indicates the opposite side of the image.
class CurveCollector {
 public:
  explicit CurveCollector(const ImageSize& size)
      : max_gap_px_(std::max(size.width, size.height) / 4.0) {}

  void Add(const std::optional<Eigen::Vector2d>& pixel) {
    if (!pixel ||
        (!curve_.empty() && !((*pixel - curve_.back()).norm() <= max_gap_px_)))
      End();
    if (pixel) curve_.push_back(*pixel);
  }
  void End() {
    if (curve_.size() > 1) curves_.push_back(std::move(curve_));
    curve_.clear();
  }
  std::vector<PixelCurve> Curves() {
    End();
    return std::move(curves_);
  }

 private:
  const double max_gap_px_;
  PixelCurve curve_;
  std::vector<PixelCurve> curves_;
};

// Projects a ray to the view, if the pixel is not far outside the image, where
// pinhole projections are numerically useless.
std::optional<Eigen::Vector2d> PixelNearImage(const VirtualView& view,
                                              const Eigen::Vector3d& ray) {
  const auto pixel = view.Pixel(ray);
  const double margin_px = std::max(view.size.width, view.size.height) / 8.0;
  if (!pixel || !WholeImage(view.size).Contains(*pixel, margin_px))
    return std::nullopt;
  return pixel;
}

void AddEdge(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
             std::vector<PixelCurve>* curves) {
  constexpr double kStepPx = 4;
  const int steps =
      std::max(1, static_cast<int>(std::ceil((to - from).norm() / kStepPx)));
  PixelCurve curve;
  for (int k = 0; k <= steps; ++k)
    curve.push_back(from + (to - from) * k / steps);
  curves->push_back(std::move(curve));
}

// Returns the number of steps around the cube, starting at a corner, such that
// steps are small compared to the view's field, and the other corners are among
// them.
int StepsAroundCube(const VirtualView& view) {
  constexpr int kLeast = 180, kMost = 1000;  // for an eighth
  const double visible_angle_deg =
      std::max(view.HorizontalFieldOfViewDeg(), view.VerticalFieldOfViewDeg());
  const double min_length_px = 64 * 45 / std::max(visible_angle_deg, 1e-3);
  return 8 * static_cast<int>(std::clamp<double>(min_length_px, kLeast, kMost));
}

// Returns a point of the square in which a plane orthogonal to an axis, at an
// offset, intersects the cube.
Eigen::Vector3d ComputeClosedCurvePoint(int axis, double offset,
                                        double angle_rad) {
  Eigen::Vector3d point;
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  const double reach = std::max(std::abs(c), std::abs(s));
  point[axis] = offset;
  point[(axis + 1) % 3] = c / reach;
  point[(axis + 2) % 3] = s / reach;
  return point;
}

}  // namespace

std::vector<PixelCurve> MakeRoomLines(const VirtualView& view,
                                      const Eigen::Matrix3d& camera_from_room,
                                      double square) {
  const int num_steps = StepsAroundCube(view);
  const int num_squares = static_cast<int>(std::lround(2 / square));
  CurveCollector collector(view.size);
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k <= num_squares; ++k) {
      for (int step = 0; step <= num_steps; ++step)
        collector.Add(PixelNearImage(
            view,
            camera_from_room * ComputeClosedCurvePoint(
                                   axis, k * square - 1,
                                   M_PI / 4 + step * 2 * M_PI / num_steps)));
      collector.End();
    }
  }
  return collector.Curves();
}

double ComputeViewSquareSize(const VirtualView& view) {
  constexpr double kAcross = 10;
  const double hfov_rad = view.HorizontalFieldOfViewDeg() * M_PI / 180;
  const double square = std::exp2(std::round(std::log2(hfov_rad / kAcross)));
  return std::clamp(square, 1.0 / 256, 0.25);
}

std::vector<PixelCurve> ComputeValidOutline(const ValidityMask& mask,
                                            const ImageSize& size) {
  std::vector<PixelCurve> curves;
  const auto is_valid = [&](int i, int j) {
    return i >= 0 && i < mask.columns && j >= 0 && j < mask.rows &&
           mask.is_valid[j * mask.columns + i];
  };
  const auto corner = [&](int i, int j) {
    return Eigen::Vector2d(
        std::min(i * mask.knot_spacing_px, size.width) - 0.5,
        std::min(j * mask.knot_spacing_px, size.height) - 0.5);
  };
  for (int j = 0; j <= mask.rows; ++j) {
    for (int i = 0; i <= mask.columns; ++i) {
      if (is_valid(i, j) != is_valid(i - 1, j))
        AddEdge(corner(i, j), corner(i, j + 1), &curves);
      if (is_valid(i, j) != is_valid(i, j - 1))
        AddEdge(corner(i, j), corner(i + 1, j), &curves);
    }
  }
  return curves;
}

std::vector<PixelCurve> ComputeAreaOutline(const Area& area) {
  std::vector<PixelCurve> curves;
  const Eigen::Vector2d corners[] = {{area.x0, area.y0},
                                     {area.x1, area.y0},
                                     {area.x1, area.y1},
                                     {area.x0, area.y1}};
  for (int k = 0; k < 4; ++k)
    AddEdge(corners[k], corners[(k + 1) % 4], &curves);
  return curves;
}

std::vector<PixelCurve> ProjectCurves(const CameraModel& camera,
                                      const VirtualView& view,
                                      const std::vector<PixelCurve>& curves) {
  const Area& area = camera.area();
  CurveCollector collector(view.size);
  for (const PixelCurve& curve : curves) {
    for (const Eigen::Vector2d& pixel : curve) {
      std::optional<Eigen::Vector3d> ray;
      if (area.Contains(pixel, 1))
        ray = camera.Unproject({std::clamp(pixel.x(), area.x0, area.x1),
                                std::clamp(pixel.y(), area.y0, area.y1)});
      collector.Add(ray ? PixelNearImage(view, *ray) : std::nullopt);
    }
    collector.End();
  }
  return collector.Curves();
}

std::vector<PixelCurve> ComputeViewEdge(const CameraModel& camera,
                                        const VirtualView& view) {
  // Slightly inside the view, since projections are undefined on its edge.
  constexpr double kInsetPx = 1e-3;
  std::vector<PixelCurve> seen;
  const double x1 = view.size.width - 0.5 - kInsetPx;
  const double y1 = view.size.height - 0.5 - kInsetPx;
  const double low = kInsetPx - 0.5;
  for (const PixelCurve& edge : ComputeAreaOutline({low, low, x1, y1})) {
    CurveCollector collector(camera.image_size());
    std::optional<Eigen::Vector2d> source;
    for (const Eigen::Vector2d& pixel : edge) {
      const auto ray = view.Direction(pixel);
      source = ray ? camera.Project(*ray, source ? &*source : nullptr, 0)
                   : std::nullopt;
      collector.Add(source);
    }
    for (PixelCurve& curve : collector.Curves())
      seen.push_back(std::move(curve));
  }
  return seen;
}

}  // namespace raygrid
