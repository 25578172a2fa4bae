#include "camera/camera_uncertainty.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace raygrid {

namespace {

// A position on a lattice: the node at the top left, and the fractions of the
// distance to the next nodes.
struct LatticePosition {
  int node;
  double x, y;
};
LatticePosition LocateInLattice(int columns, int rows, const Area& area,
                                const Eigen::Vector2d& pixel) {
  const auto interval = [](double position, int count) {
    return std::clamp(static_cast<int>(position), 0, count - 2);
  };
  const double x = (pixel.x() - area.x0) / area.width() * (columns - 1);
  const double y = (pixel.y() - area.y0) / area.height() * (rows - 1);
  const int i = interval(x, columns), j = interval(y, rows);
  return {j * columns + i, x - i, y - j};
}

}  // namespace

double UncertaintyLattice::At(const Area& area,
                              const Eigen::Vector2d& pixel) const {
  const LatticePosition place = LocateInLattice(columns, rows, area, pixel);
  const int nodes[] = {place.node, place.node + 1, place.node + columns,
                       place.node + columns + 1};
  const double weights[] = {(1 - place.x) * (1 - place.y),
                            place.x * (1 - place.y), (1 - place.x) * place.y,
                            place.x * place.y};
  const int nearest = (place.x < 0.5 ? 0 : 1) + (place.y < 0.5 ? 0 : 2);
  if (std::isnan(stddev_px[nodes[nearest]])) return NAN;
  double sum = 0, sum_of_weights = 0;
  for (int k = 0; k < 4; ++k) {
    if (std::isnan(stddev_px[nodes[k]])) continue;
    sum += weights[k] * stddev_px[nodes[k]];
    sum_of_weights += weights[k];
  }
  return sum / sum_of_weights;
}

Eigen::Vector2d ErrorModes::At(size_t mode, const Area& area,
                               const Eigen::Vector2d& pixel) const {
  const LatticePosition place = LocateInLattice(columns, rows, area, pixel);
  const Eigen::Vector2d* corner = &displacements_px[mode][place.node];
  const Eigen::Vector2d upper = corner[0] + place.x * (corner[1] - corner[0]);
  const Eigen::Vector2d lower =
      corner[columns] + place.x * (corner[columns + 1] - corner[columns]);
  return upper + place.y * (lower - upper);
}

double UncertaintyLattice::MedianPx() const {
  const Area all = {0, 0, 1, 1};
  return MedianPx(all, all);
}

double UncertaintyLattice::MedianPx(const Area& area, const Area& part) const {
  std::vector<double> known;
  for (int k = 0; k < columns * rows; ++k) {
    const Eigen::Vector2d place(
        area.x0 + area.width() * (k % columns) / (columns - 1),
        area.y0 + area.height() * (k / columns) / (rows - 1));
    if (std::isfinite(stddev_px[k]) && part.Contains(place))
      known.push_back(stddev_px[k]);
  }
  if (known.empty()) return NAN;
  const auto median =
      known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
  std::nth_element(known.begin(), median, known.end());
  return *median;
}

ValidityMask ValidityMask::Over(const ImageSize& size) {
  const double longer = std::max(size.width, size.height);
  ValidityMask mask;
  mask.knot_spacing_px =
      1 << std::clamp(static_cast<int>(std::lround(std::log2(longer / 40))), 2,
                      8);
  mask.columns = NumCells(size.width, mask.knot_spacing_px);
  mask.rows = NumCells(size.height, mask.knot_spacing_px);
  mask.is_valid.assign(mask.columns * mask.rows, false);
  return mask;
}

int ValidityMask::CellIndex(const Eigen::Vector2d& pixel) const {
  const auto cell = [this](double position, int count) {
    return std::clamp(static_cast<int>((position + 0.5) / knot_spacing_px), 0,
                      count - 1);
  };
  return cell(pixel.y(), rows) * columns + cell(pixel.x(), columns);
}

Eigen::Vector2d ValidityMask::CellCenter(int cell) const {
  return {(cell % columns + 0.5) * knot_spacing_px - 0.5,
          (cell / columns + 0.5) * knot_spacing_px - 0.5};
}

bool ValidityMask::HasValidCells() const {
  return std::find(is_valid.begin(), is_valid.end(), true) != is_valid.end();
}

void ValidityMask::InvalidateAbove(double max_stddev_px,
                                   const UncertaintyLattice& lattice,
                                   const Area& area) {
  const double half = knot_spacing_px / 2.0;
  for (size_t cell = 0; cell < is_valid.size(); ++cell) {
    const Eigen::Vector2d center = CellCenter(static_cast<int>(cell));
    // Standard deviations are nearly bilinear within a cell, so its corners are
    // sufficient.
    for (const double dy : {-half, half})
      for (const double dx : {-half, half}) {
        const Eigen::Vector2d corner(
            std::clamp(center.x() + dx, area.x0, area.x1),
            std::clamp(center.y() + dy, area.y0, area.y1));
        if (!(lattice.At(area, corner) <= max_stddev_px))
          is_valid[cell] = false;
      }
  }
}

CameraUncertainty CameraUncertainty::FromMask(const ValidityMask& mask) {
  CameraUncertainty known;
  known.lattice = {2, 2, std::vector<double>(4, NAN)};
  known.mask = mask;
  known.max_stddev_px = NAN;
  return known;
}

bool CameraUncertainty::HasStdDevs() const {
  return std::isfinite(max_stddev_px);
}

double CameraUncertainty::ValidFraction(const ImageSize& size,
                                        const Area& area) const {
  // Counts rows and columns instead of pixels, because cells and the area are
  // rectangles and images may have hundreds of megapixels.
  std::vector<int64_t> in_column(mask.columns), in_row(mask.rows);
  for (int x = 0; x < size.width; ++x)
    in_column[mask.CellIndex({x, 0}) % mask.columns] +=
        area.Contains({static_cast<double>(x), area.y0});
  for (int y = 0; y < size.height; ++y)
    in_row[mask.CellIndex({0, y}) / mask.columns] +=
        area.Contains({area.x0, static_cast<double>(y)});
  int64_t count = 0;
  for (int j = 0; j < mask.rows; ++j)
    for (int i = 0; i < mask.columns; ++i)
      if (mask.is_valid[j * mask.columns + i])
        count += in_column[i] * in_row[j];
  return static_cast<double>(count) /
         (static_cast<double>(size.width) * size.height);
}

}  // namespace raygrid
