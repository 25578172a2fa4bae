#include "packing/rectification.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dataset/error.h"
#include "packing/alpha_view.h"
#include "packing/view_request.h"

namespace raygrid {
namespace {

[[noreturn]] void FailToRectify(const StereoCamera& first,
                                const StereoCamera& second,
                                const std::string& why) {
  throw Error(ExitCode::kUsage,
              fmt::format("{} and {}: {}", first.name, second.name, why));
}

// The vector from the first camera to the second, in the axes of each.
struct StereoBaseline {
  Eigen::Vector3d baseline_in_first, baseline_in_second;
  bool is_vertical = false;
  // The sign of the baseline along the axis, in both images: 1 or -1; 0 if the
  // images do not agree.
  int direction = 0;
};

StereoBaseline ComputeBaseline(const Pose& second_from_first) {
  StereoBaseline baseline;
  baseline.baseline_in_first = second_from_first.Inverse().translation;
  baseline.baseline_in_second =
      second_from_first.rotation * baseline.baseline_in_first;
  const Eigen::Vector3d &a = baseline.baseline_in_first,
                        &b = baseline.baseline_in_second;
  baseline.is_vertical = std::hypot(a.y(), b.y()) > std::hypot(a.x(), b.x());
  const int axis = baseline.is_vertical ? 1 : 0;
  if (a[axis] > 0 && b[axis] > 0) baseline.direction = 1;
  if (a[axis] < 0 && b[axis] < 0) baseline.direction = -1;
  return baseline;
}

// Returns the rotation from the views' axes to those of the first camera.
Eigen::Matrix3d ComputeViewRotation(const StereoBaseline& baseline,
                                    const Eigen::Vector3d& mean_z) {
  const Eigen::Vector3d along = baseline.baseline_in_first.normalized();
  const Eigen::Vector3d across = baseline.is_vertical
                                     ? along.cross(mean_z).normalized()
                                     : mean_z.cross(along).normalized();
  Eigen::Matrix3d axes;
  if (baseline.is_vertical)
    axes << across, along, across.cross(along);
  else
    axes << along, across, along.cross(across);
  return axes;
}

// Returns the fraction of the first camera's pixels that the second camera
// observes, too, for points at infinity.
double ComputeDistantOverlap(const StereoCamera& first,
                             const StereoCamera& second,
                             const Eigen::Quaterniond& second_from_first) {
  constexpr int kSteps = 48;
  constexpr double kRoundingPx = 1e-3;
  const Area& area = first.camera.area();
  int num_seen = 0, num_common = 0;
  for (int j = 0; j <= kSteps; ++j)
    for (int i = 0; i <= kSteps; ++i) {
      const auto ray =
          first.camera.Unproject({area.x0 + area.width() * i / kSteps,
                                  area.y0 + area.height() * j / kSteps});
      if (!ray) continue;
      ++num_seen;
      num_common +=
          second.camera.Project(second_from_first * *ray, nullptr, kRoundingPx)
              .has_value();
    }
  return num_seen == 0 ? 0 : static_cast<double>(num_common) / num_seen;
}

void RequireRectifiable(const StereoCamera& first, const StereoCamera& second,
                        const StereoBaseline& baseline,
                        const Eigen::Vector3d& mean_z,
                        const Rectification& pair) {
  constexpr double kMinBaselineM = 1e-6;
  constexpr double kMinFromAxisDeg = 30;
  if (!(baseline.baseline_in_first.norm() > kMinBaselineM))
    FailToRectify(first, second,
                  "have no baseline; choose cameras at different positions");
  if (pair.overlap == 0 || mean_z.norm() < 1e-9)
    FailToRectify(first, second,
                  fmt::format("their fields of view do not overlap at infinity "
                              "(optical axes {:.0f} degrees apart); choose "
                              "cameras with similar viewing directions",
                              pair.angle_deg));
  const double from_axis_deg =
      std::acos(std::min(1.0, std::abs(mean_z.normalized().dot(
                                  baseline.baseline_in_first.normalized())))) *
      180 / M_PI;
  if (from_axis_deg < kMinFromAxisDeg)
    FailToRectify(first, second,
                  fmt::format("the baseline is only {:.0f} degrees from their "
                              "mean viewing direction, so the epipoles lie in "
                              "the image; choose cameras side by side",
                              from_axis_deg));
  if (baseline.direction < 0)
    FailToRectify(
        first, second,
        baseline.is_vertical
            ? fmt::format("{0} is below {1}, so disparities would be negative; "
                          "use --left {1} --right {0}, the upper camera first",
                          first.name, second.name)
            : fmt::format("{0} is to the right of {1}, so disparities would be "
                          "negative; use --left {1} --right {0}",
                          first.name, second.name));
}

// Narrows the view to a useful field, with the same centre: a pinhole stretches
// the image fourfold at 60 degrees.
VirtualView LimitFieldOfView(const VirtualView& view) {
  constexpr double kMaxHalfFovRad = 60 * M_PI / 180;
  const Eigen::Vector2d last(view.size.width - 1, view.size.height - 1);
  const double focal_px = view.focal_px.x();
  const double least_px = std::max(view.size.width, view.size.height) / 2.0 /
                          std::tan(kMaxHalfFovRad);
  if (focal_px >= least_px) return view;
  return MakeCentralView(view, view.size,
                         (last / 2 - view.center_px) / focal_px, least_px);
}

VirtualView SharedView(const StereoCamera& first, const StereoCamera& second,
                       const std::vector<CameraAndPlane>& cameras,
                       const ViewRequest& request) {
  if (request.hfov_deg) {
    VirtualView view = MakeView(first.camera, request);
    view.camera_from_view = cameras[0].plane.camera_from_view;
    return view;
  }
  const ImageSize& size = request.size;
  const double alpha = request.alpha.value_or(0);
  std::optional<VirtualView> largest;
  if (alpha < 1) {
    largest = FindLargestViewWithoutBorder(cameras, size);
    if (!largest)
      FailToRectify(first, second,
                    "no rectified view without invalid pixels exists; set hfov "
                    "to allow a border");
    if (!request.alpha) return LimitFieldOfView(*largest);
    if (alpha == 0) return *largest;
  }
  const EnclosingView all = FindSmallestEnclosingView(cameras, size);
  if (!all.view)
    FailToRectify(
        first, second,
        fmt::format("alpha {}: a pinhole view cannot contain all pixels, which "
                    "extend up to {:.0f} degrees off axis; use alpha 0 or hfov",
                    alpha, all.max_stretch_rad * 180 / M_PI));
  return alpha == 1 ? *all.view : InterpolateViews(*largest, *all.view, alpha);
}

}  // namespace

Eigen::Matrix<double, 3, 4> Rectification::P(int camera) const {
  const VirtualView& view = views[camera];
  Eigen::Matrix<double, 3, 4> projection;
  projection << view.focal_px.x(), 0, view.center_px.x(), 0,  //
      0, view.focal_px.y(), view.center_px.y(), 0,            //
      0, 0, 1, 0;
  const int axis = is_vertical ? 1 : 0;
  if (camera == 1) projection(axis, 3) = -view.focal_px[axis] * baseline_m;
  return projection;
}

Eigen::Matrix4d Rectification::Q() const {
  const VirtualView& view = views[0];
  Eigen::Matrix4d point_from_pixel;
  point_from_pixel << 1, 0, 0, -view.center_px.x(),  //
      0, 1, 0, -view.center_px.y(),                  //
      0, 0, 0, view.focal_px.x(),                    //
      0, 0, 1 / baseline_m, 0;
  return point_from_pixel;
}

Rectification Rectify(const StereoCamera& first, const StereoCamera& second,
                      const RectificationRequest& request) {
  ViewRequest view;
  view.size =
      request.size.width != 0 ? request.size : first.camera.image_size();
  view.hfov_deg = request.hfov_deg;
  view.alpha = request.alpha;
  RequireValidView(view);
  const Pose second_from_first =
      second.camera_from_rig * first.camera_from_rig.Inverse();
  const StereoBaseline baseline = ComputeBaseline(second_from_first);
  const Eigen::Vector3d second_z =
      second_from_first.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d mean_z = (Eigen::Vector3d::UnitZ() + second_z) / 2;

  Rectification pair;
  pair.angle_deg = std::acos(std::clamp(second_z.z(), -1.0, 1.0)) * 180 / M_PI;
  pair.overlap =
      ComputeDistantOverlap(first, second, second_from_first.rotation);
  RequireRectifiable(first, second, baseline, mean_z, pair);
  pair.is_vertical = baseline.is_vertical;
  pair.baseline_m = baseline.baseline_in_first.norm();
  VirtualView plane;
  plane.focal_px = {1, 1};
  plane.camera_from_view = ComputeViewRotation(baseline, mean_z);
  std::vector<CameraAndPlane> cameras = {{first.camera, plane}};
  plane.camera_from_view =
      second_from_first.rotation.toRotationMatrix() * plane.camera_from_view;
  cameras.push_back({second.camera, plane});
  pair.views.fill(SharedView(first, second, cameras, view));
  pair.views[1].camera_from_view = plane.camera_from_view;
  RequirePackableView(pair.views[0]);
  return pair;
}

bool IsOrderReversed(const Pose& second_from_first) {
  return ComputeBaseline(second_from_first).direction < 0;
}

}  // namespace raygrid
