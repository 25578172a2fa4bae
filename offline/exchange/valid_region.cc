#include "exchange/valid_region.h"

#include <algorithm>
#include <cstdint>

namespace raygrid {
namespace {

// A cell, or its top left corner.
struct Place {
  int column, row;

  bool operator==(const Place& other) const {
    return column == other.column && row == other.row;
  }
  Place operator+(const Place& step) const {
    return {column + step.column, row + step.row};
  }
};

// Right, down, left and up: each step is the previous one rotated clockwise.
constexpr Place kSteps[4] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};

bool RegionContains(const ValidityMask& mask, const Place& cell) {
  return cell.column >= 0 && cell.column < mask.columns && cell.row >= 0 &&
         cell.row < mask.rows &&
         mask.is_valid[cell.row * mask.columns + cell.column];
}

// Removes the connected component of a cell from *rest and returns it.
ValidityMask ExtractConnectedCells(int first, ValidityMask* rest) {
  ValidityMask part = *rest;
  part.is_valid.assign(part.is_valid.size(), false);
  std::vector<int> next = {first};
  rest->is_valid[first] = false;
  while (!next.empty()) {
    const int cell = next.back();
    next.pop_back();
    part.is_valid[cell] = true;
    for (const Place& step : kSteps) {
      const Place beside =
          Place{cell % part.columns, cell / part.columns} + step;
      if (!RegionContains(*rest, beside)) continue;
      next.push_back(beside.row * part.columns + beside.column);
      rest->is_valid[next.back()] = false;
    }
  }
  return part;
}

int64_t CountValidCells(const ValidityMask& mask) {
  return std::count(mask.is_valid.begin(), mask.is_valid.end(), true);
}

// Returns the largest connected component, or the first of several equally
// large ones. Empty if no cell is valid.
ValidityMask FindLargestComponent(ValidityMask rest) {
  ValidityMask largest = rest;
  largest.is_valid.assign(rest.is_valid.size(), false);
  for (size_t cell = 0; cell < rest.is_valid.size(); ++cell) {
    if (!rest.is_valid[cell]) continue;
    ValidityMask part = ExtractConnectedCells(static_cast<int>(cell), &rest);
    if (CountValidCells(part) > CountValidCells(largest))
      largest = std::move(part);
  }
  return largest;
}

// Whether the mask contains the cell on the right of a step from a corner. The
// cell on the left of a step is on the right of the previous step.
bool IsCellValidOnRight(const ValidityMask& mask, const Place& corner,
                        int step) {
  constexpr Place kRight[4] = {{0, 0}, {-1, 0}, {-1, -1}, {0, -1}};
  return RegionContains(mask, corner + kRight[step % 4]);
}

Eigen::Vector2d ToPixel(const Place& corner, const ValidityMask& mask,
                        const ImageSize& size) {
  return {std::min(corner.column * mask.knot_spacing_px, size.width) - 0.5,
          std::min(corner.row * mask.knot_spacing_px, size.height) - 0.5};
}

// Returns the centre of a cell, clipped to the image.
Eigen::Vector2d GetCellCenter(const Place& cell, const ValidityMask& mask,
                              const ImageSize& size) {
  return (ToPixel(cell, mask, size) + ToPixel(cell + Place{1, 1}, mask, size)) /
         2;
}

// Even-odd rule: whether a ray to the right of a point crosses the contour an
// odd number of times.
bool IsInside(const ValidRegion& region, const Eigen::Vector2d& place) {
  bool is_inside = false;
  for (size_t k = 0; k < region.size(); ++k) {
    const Eigen::Vector2d &a = region[k], &b = region[(k + 1) % region.size()];
    if ((a.y() > place.y()) == (b.y() > place.y())) continue;
    const double part = (place.y() - a.y()) / (b.y() - a.y());
    if (place.x() < a.x() + part * (b.x() - a.x())) is_inside = !is_inside;
  }
  return is_inside;
}

// Sets the cells of a mask whose centres are in a region.
ValidityMask SelectCellsInside(const ValidRegion& region, ValidityMask mask,
                               const ImageSize& size) {
  for (size_t k = 0; k < mask.is_valid.size(); ++k) {
    const int cell = static_cast<int>(k);
    mask.is_valid[k] = IsInside(
        region,
        GetCellCenter({cell % mask.columns, cell / mask.columns}, mask, size));
  }
  return mask;
}

}  // namespace

// Traces the contour clockwise, starting at the component's first cell; the
// component is always on the right.
ValidRegion ComputeValidRegion(const ValidityMask& mask,
                               const ImageSize& size) {
  const ValidityMask part = FindLargestComponent(mask);
  const auto first =
      std::find(part.is_valid.begin(), part.is_valid.end(), true);
  if (first == part.is_valid.end()) return {};
  const int cell = static_cast<int>(first - part.is_valid.begin());
  const Place start = {cell % part.columns, cell / part.columns};
  ValidRegion region = {ToPixel(start, part, size)};
  int step = 0;
  for (Place corner = start + kSteps[step]; !(corner == start);
       corner = corner + kSteps[step]) {
    const int before = step;
    if (!IsCellValidOnRight(part, corner, step))
      step = (step + 1) % 4;
    else if (IsCellValidOnRight(part, corner, step + 3))
      step = (step + 3) % 4;
    if (step != before) region.push_back(ToPixel(corner, part, size));
  }
  region.push_back(region.front());
  return region;
}

ValidityMask MakeValidityMask(const ValidRegion& region,
                              const ImageSize& size) {
  return SelectCellsInside(region, ValidityMask::Over(size), size);
}

RegionLoss ComputeRegionLoss(const ValidityMask& mask, const ImageSize& size) {
  const ValidityMask held =
      SelectCellsInside(ComputeValidRegion(mask, size), mask, size);
  RegionLoss loss;
  for (size_t k = 0; k < mask.is_valid.size(); ++k) {
    loss.num_left_out += mask.is_valid[k] && !held.is_valid[k];
    loss.num_held += !mask.is_valid[k] && held.is_valid[k];
  }
  return loss;
}

}  // namespace raygrid
