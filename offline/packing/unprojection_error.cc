#include "packing/unprojection_error.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "blob_layout.h"
#include "bytes.h"
#include "dataset/parallel_for.h"
#include "packing/blob_limits.h"
#include "raygrid.h"

namespace raygrid {
namespace {

constexpr double kMaxMeasuredPixels = 1.6e7;

// Returns the minimum number of pixels per radian along a horizontal line
// through the area's centre; that of fisheyes is uniform within their image
// circle.
double ComputeMinPixelsPerRadian(const CameraModel& camera) {
  constexpr int kSteps = 16;
  const Area& area = camera.area();
  const auto ray_at = [&](int step) {
    return camera.Unproject(
        {area.x0 + area.width() * step / kSteps, (area.y0 + area.y1) / 2});
  };
  double min_samples = INFINITY;
  for (int k = 0; k < kSteps; ++k) {
    const auto from = ray_at(k), to = ray_at(k + 1);
    if (from && to)
      min_samples = std::min(min_samples,
                             area.width() / kSteps / from->cross(*to).norm());
  }
  return min_samples;
}

UnprojectionError MeasureOpened(const PackingTruth& truth,
                                const rg_camera& packed, int num_threads) {
  const auto end_px = [&](int field) {
    return rg_load_i32(packed.grid + field) / 65536.0;
  };
  const int first = static_cast<int>(std::ceil(end_px(RG_GRID_X0)));
  const int first_row = static_cast<int>(std::ceil(end_px(RG_GRID_Y0)));
  const int last = static_cast<int>(std::floor(end_px(RG_GRID_X1)));
  const int last_row = static_cast<int>(std::floor(end_px(RG_GRID_Y1)));
  const double num_pixels = std::max(
      1.0, static_cast<double>(last - first + 1) * (last_row - first_row + 1));
  const int step =
      static_cast<int>(std::ceil(std::sqrt(num_pixels / kMaxMeasuredPixels)));
  const int num_rows = (last_row - first_row) / step + 1;
  constexpr double kNegligibleRotation = 20;
  const double min_px_per_radian =
      kNegligibleRotation * ComputeMinPixelsPerRadian(truth.camera);
  std::vector<UnprojectionError> worst(std::max(num_rows, 0));
  ParallelFor(num_rows, num_threads, [&](int row) {
    const int y = first_row + step * row;
    for (int x = first; x <= last; x += step) {
      const Eigen::Vector2d pixel(x, y);
      const bool is_valid = truth.IsValidAt(pixel);
      const CameraModel& camera = is_valid ? truth.camera : truth.elsewhere;
      const auto exact = camera.Unproject(pixel);
      LinearizedProjection projection;
      rg_ray ray;
      if (!exact || !camera.Linearize(*exact, &pixel, 1, &projection) ||
          rg_unproject(&packed, {x * 65536, y * 65536}, &ray) != RG_OK)
        continue;
      const Eigen::Vector3d direction =
          Eigen::Vector3d(ray.x_q30, ray.y_q30, ray.z_q30) / (1 << 30);
      worst[row].rad = std::max(worst[row].rad, direction.cross(*exact).norm());
      if (is_valid && projection.J_point.norm() < min_px_per_radian)
        worst[row].px =
            std::max(worst[row].px, (projection.J_point * direction).norm());
    }
  });
  UnprojectionError total;
  for (const UnprojectionError& error : worst) {
    total.px = std::max(total.px, error.px);
    total.rad = std::max(total.rad, error.rad);
  }
  return total;
}

}  // namespace

UnprojectionError MeasureUnprojection(const PackingTruth& truth,
                                      const std::string& blob,
                                      int num_threads) {
  std::vector<uint32_t> words((blob.size() + 3) / 4);
  std::memcpy(words.data(), blob.data(), blob.size());
  rg_camera packed;
  const rg_status status =
      rg_camera_open(&packed, words.data(), static_cast<uint32_t>(blob.size()));
  if (status != RG_OK) ThrowDoesNotFitBlob(rg_status_text(status));
  return MeasureOpened(truth, packed, num_threads);
}

}  // namespace raygrid
