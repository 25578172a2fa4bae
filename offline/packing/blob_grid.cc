#include "packing/blob_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dataset/error.h"
#include "packing/blob_limits.h"

namespace raygrid {
namespace {

int32_t Q16(double value) {
  return static_cast<int32_t>(std::lround(value * 65536));
}

// The area inside camera's that the format can say.
Area RepresentableArea(const Area& area) {
  constexpr double kUnit = 65536;
  return {
      std::ceil(area.x0 * kUnit) / kUnit, std::ceil(area.y0 * kUnit) / kUnit,
      std::floor(area.x1 * kUnit) / kUnit, std::floor(area.y1 * kUnit) / kUnit};
}

// The worst angle-times-focal-length between a model and its grid, where it is
// trusted, if it is anywhere.
double FitError(const CameraModel& model, const TrustMask* trusted,
                const CentralGeneric& grid) {
  double worst = 0;
  const Area& area = grid.area();
  for (int j = 0; j <= 60; ++j) {
    for (int i = 0; i <= 80; ++i) {
      const Eigen::Vector2d pixel(area.x0 + area.width() * i / 80,
                                  area.y0 + area.height() * j / 60);
      if (trusted && !trusted->Trusts(pixel)) continue;
      const auto ray = model.Unproject(pixel);
      if (!ray) continue;
      const auto image = grid.Project(*ray, &pixel, 5);
      worst = std::max(worst, image ? (*image - pixel).norm() : INFINITY);
    }
  }
  return worst;
}

// The camera as a grid over a representable area.
CentralGeneric AsGrid(const CameraModel& camera, const TrustMask* trusted) {
  const Area area = RepresentableArea(camera.area());
  const auto* grid = dynamic_cast<const CentralGeneric*>(&camera);
  if (grid && area.x0 == camera.area().x0 && area.y0 == camera.area().y0 &&
      area.x1 == camera.area().x1 && area.y1 == camera.area().y1)
    return *grid;
  double error = INFINITY;
  for (int half_log2 = 2; half_log2 <= 14; ++half_log2) {
    const double cell_px = std::max(area.width(), area.height()) /
                           std::exp2(half_log2 / 2.0);  // 2 to 128 cells
    CentralGeneric fit =
        FitCentralGeneric(camera, area, NumControlPoints(area.width(), cell_px),
                          NumControlPoints(area.height(), cell_px));
    error = FitError(camera, trusted, fit);
    if (error <= kMaxPackingErrorPx / 2) return fit;
  }
  throw Error(ExitCode::kQuality,
              fmt::format("no grid follows this {} camera {}; is it valid over "
                          "its whole area?",
                          camera.Name(),
                          std::isfinite(error)
                              ? fmt::format("closer than {:.4f} px", error)
                              : "and leads back to its pixels"));
}

// Whether a trusted cell's rays depend on a control point of the grid: within
// two of its cells.
bool IsTrustedNear(const TrustMask& mask, const BSplineSurface& surface,
                   int index) {
  const Eigen::Array2d reach =
      2 * Eigen::Array2d(surface.cell_width(), surface.cell_height()) +
      mask.cell_px / 2.0;
  for (size_t k = 0; k < mask.is_trusted.size(); ++k) {
    const Eigen::Array2d distance =
        mask.CellCenter(static_cast<int>(k)) - surface.PixelOf(index);
    if (mask.is_trusted[k] && (distance.abs() < reach).all()) return true;
  }
  return false;
}

// Draws control points beyond what the format holds back to it, where no
// trusted pixel sees by them: as in the corners around a fisheye's image
// circle.
void DrawIntoChart(const TrustMask* trusted, CentralGeneric* grid) {
  const double limit =
      std::ldexp(RG_CONTROL_POINT_LIMIT - 1.0, -RG_CONTROL_POINT_BITS);
  BSplineSurface surface = grid->surface();
  for (int index = 0; index < surface.num_points(); ++index) {
    Eigen::Vector2d& point = surface.points()[index];
    const double largest = point.cwiseAbs().maxCoeff();
    if (largest <= limit) continue;
    if (!std::isfinite(largest) || !trusted ||
        IsTrustedNear(*trusted, surface, index))
      ThrowDoesNotFitBlob(
          "it looks farther back than 151 degrees from its axis");
    point *= limit / largest;
  }
  *grid = CentralGeneric(grid->image_size(), surface);
}

}  // namespace

CentralGeneric MakeBlobGrid(const CameraModel& camera,
                            const TrustMask* trusted) {
  CentralGeneric grid = AsGrid(camera, trusted);
  DrawIntoChart(trusted, &grid);
  return grid;
}

GridSection QuantizeGrid(const CentralGeneric& camera) {
  GridSection grid;
  rg_grid_section& s = grid.section;
  const Area& area = camera.area();
  s.x0_q16 = Q16(area.x0);
  s.y0_q16 = Q16(area.y0);
  s.x1_q16 = Q16(area.x1);
  s.y1_q16 = Q16(area.y1);
  s.columns = static_cast<uint16_t>(camera.surface().columns());
  s.rows = static_cast<uint16_t>(camera.surface().rows());
  grid.control_points.columns = s.columns;
  grid.control_points.rows = s.rows;
  if (camera.surface().cell_width() <= 1.01 ||
      camera.surface().cell_height() <= 1.01)
    ThrowDoesNotFitBlob("its cells are not larger than a pixel");
  s.scale_x_q32 = rg_grid_scale_q32(s.columns - 3u, s.x1_q16 - s.x0_q16);
  s.scale_y_q32 = rg_grid_scale_q32(s.rows - 3u, s.y1_q16 - s.y0_q16);
  for (const Eigen::Vector2d& point : camera.surface().points()) {
    for (int c = 0; c < 2; ++c)
      grid.control_points.values.push_back(static_cast<int32_t>(
          std::lround(std::ldexp(point[c], RG_CONTROL_POINT_BITS))));
  }
  return grid;
}

std::vector<int32_t> QuantizeLinePoints(const NonCentralGeneric& camera,
                                        const BSplineSurface& grid) {
  const BSplineSurface& own = camera.directions();
  const bool is_same =
      own.columns() == grid.columns() && own.rows() == grid.rows() &&
      own.area().x0 == grid.area().x0 && own.area().y0 == grid.area().y0 &&
      own.area().x1 == grid.area().x1 && own.area().y1 == grid.area().y1;
  const std::vector<Eigen::Vector3d> points =
      is_same ? camera.points()
              : FitNonCentralGeneric(camera, grid.area(), grid.columns(),
                                     grid.rows())
                    .points();
  std::vector<int32_t> quantized;
  for (const Eigen::Vector3d& point : points) {
    for (int c = 0; c < 3; ++c) {
      const double value = std::ldexp(point[c], RG_LINE_POINT_BITS);
      if (!(std::abs(value) <= RG_LINE_POINT_LIMIT))
        ThrowDoesNotFitBlob("its lines lie farther than 7.9 m from its centre");
      quantized.push_back(static_cast<int32_t>(std::lround(value)));
    }
  }
  return quantized;
}

}  // namespace raygrid
