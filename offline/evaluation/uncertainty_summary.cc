#include "evaluation/uncertainty_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

// Cell of the image, and the number of its pixels to be counted.
struct CountedCell {
  int cell = 0;
  Eigen::Vector2d center;
  double num_pixels = 0;
  bool is_calibrated = false;  // within the camera's area
};

// Lists the cells of the image, or of its image circle if known.
std::vector<CountedCell> ListCells(const CameraModel& camera,
                                   const std::optional<ImageCircle>& circle,
                                   const ValidityMask& mask) {
  const ImageSize& size = camera.image_size();
  const auto extent = [&](int index, int num_pixels) {
    return std::min(mask.knot_spacing_px,
                    num_pixels - index * mask.knot_spacing_px);
  };
  std::vector<CountedCell> cells;
  for (int cell = 0; cell < mask.columns * mask.rows; ++cell) {
    const int column = cell % mask.columns, row = cell / mask.columns;
    const double width = extent(column, size.width);
    const double height = extent(row, size.height);
    const Eigen::Vector2d center(
        column * mask.knot_spacing_px + (width - 1) / 2,
        row * mask.knot_spacing_px + (height - 1) / 2);
    if (circle && !circle->Contains(center)) continue;
    cells.push_back(
        {cell, center, width * height, camera.area().Contains(center)});
  }
  return cells;
}

double SumLanes(const std::vector<CountedCell>& cells) {
  double sum = 0;
  for (const CountedCell& cell : cells) sum += cell.num_pixels;
  return sum;
}

// Returns the third of the image, across or down, that contains a pixel: 0 to
// 2.
int GetThird(double position, int extent) {
  return std::clamp(static_cast<int>(3 * (position + 0.5) / extent), 0, 2);
}

// Joins items with commas and "and": "left", "left and right", "left, top and
// right".
std::string JoinWords(const std::vector<std::string>& words) {
  std::string text;
  for (size_t k = 0; k < words.size(); ++k)
    text += (k == 0 ? "" : k + 1 == words.size() ? " and " : ", ") + words[k];
  return text;
}

// Side or corner of the image: one of nine regions.
struct ImageRegion {
  const char* name;
  int column, row;
};
constexpr ImageRegion kSides[] = {
    {"left", 0, 1}, {"right", 2, 1}, {"top", 1, 0}, {"bottom", 1, 2}};
constexpr ImageRegion kCorners[] = {{"top left", 0, 0},
                                    {"top right", 2, 0},
                                    {"bottom left", 0, 2},
                                    {"bottom right", 2, 2}};

// Describes sides and corners with a large extrapolated fraction. Corners of a
// side that is already named are omitted.
std::string DescribePositions(
    const std::array<std::array<double, 3>, 3>& shares) {
  constexpr double kMinSideFraction = 0.2, kMinCornerFraction = 0.03;
  std::vector<std::string> sides, corners;
  std::vector<ImageRegion> named;
  for (const ImageRegion& side : kSides)
    if (shares[side.row][side.column] > kMinSideFraction) {
      sides.emplace_back(side.name);
      named.push_back(side);
    }
  for (const ImageRegion& corner : kCorners) {
    const bool belongs_to_side =
        std::any_of(named.begin(), named.end(), [&](const ImageRegion& side) {
          return (side.row == 1 && side.column == corner.column) ||
                 (side.column == 1 && side.row == corner.row);
        });
    if (!belongs_to_side &&
        shares[corner.row][corner.column] > kMinCornerFraction)
      corners.emplace_back(corner.name);
  }
  std::vector<std::string> parts;
  if (sides.size() == std::size(kSides))
    parts.emplace_back("edges");
  else if (!sides.empty())
    parts.push_back(JoinWords(sides) + (sides.size() > 1 ? " edges" : " edge"));
  if (corners.size() == std::size(kCorners))
    parts.emplace_back("corners");
  else if (!corners.empty())
    parts.push_back(JoinWords(corners) +
                    (corners.size() > 1 ? " corners" : " corner"));
  return parts.empty() ? "parts" : JoinWords(parts);
}

}  // namespace

UncertaintySummary SummarizeUncertainty(const CameraModel& camera,
                                        const CameraUncertainty& uncertainty) {
  UncertaintySummary summary;
  summary.median_px = uncertainty.lattice.MedianPx();
  const std::vector<CountedCell> cells =
      ListCells(camera, camera.image_circle(), uncertainty.mask);
  for (const CountedCell& cell : cells) {
    if (!cell.is_calibrated) continue;
    const double px = uncertainty.lattice.At(camera.area(), cell.center);
    for (size_t k = 0; k < kShareLimitsPx.size(); ++k)
      if (px < kShareLimitsPx[k]) summary.share_below[k] += cell.num_pixels;
  }
  for (double& share : summary.share_below) share /= SumLanes(cells);
  summary.valid_share = ComputeValidShare(camera, uncertainty.mask);
  return summary;
}

double ComputeValidShare(const CameraModel& camera, const ValidityMask& valid) {
  const std::vector<CountedCell> cells =
      ListCells(camera, camera.image_circle(), valid);
  double num_valid = 0;
  for (const CountedCell& cell : cells)
    if (cell.is_calibrated && valid.is_valid[cell.cell])
      num_valid += cell.num_pixels;
  return num_valid / SumLanes(cells);
}

std::string DescribeUncertainty(const UncertaintySummary& summary,
                                const CameraUncertainty& uncertainty,
                                const CameraModel& camera) {
  return fmt::format(
      "{:.0f} % of the {} is valid: supported by features, with a predicted "
      "uncertainty below {:.2g} px.",
      100 * summary.valid_share,
      camera.image_circle() ? "image circle" : "image",
      uncertainty.max_stddev_px);
}

ExtrapolatedRegion SummarizeExtrapolatedRegion(
    const CameraModel& camera, const std::optional<ImageCircle>& image_circle,
    const ValidityMask& supported, const UncertaintyLattice& lattice) {
  ExtrapolatedRegion region;
  const ImageSize& size = camera.image_size();
  std::array<std::array<double, 3>, 3> shares = {}, all = {};
  std::vector<double> uncertainties_px;
  const std::vector<CountedCell> cells =
      ListCells(camera, image_circle, supported);
  for (const CountedCell& cell : cells) {
    const int column = GetThird(cell.center.x(), size.width);
    const int row = GetThird(cell.center.y(), size.height);
    all[row][column] += cell.num_pixels;
    if (!cell.is_calibrated || supported.is_valid[cell.cell]) continue;
    shares[row][column] += cell.num_pixels;
    region.share += cell.num_pixels;
    const double px = lattice.At(camera.area(), cell.center);
    if (std::isfinite(px)) uncertainties_px.push_back(px);
  }
  if (region.share == 0) return region;
  region.share /= SumLanes(cells);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      if (all[row][column] > 0) shares[row][column] /= all[row][column];
  region.image_regions = DescribePositions(shares);
  if (!uncertainties_px.empty())
    region.p95_px = Quantile(uncertainties_px, 0.95);
  return region;
}

void InvalidateOutside(const ImageCircle& circle, ValidityMask* mask) {
  const double half = mask->knot_spacing_px / 2.0;
  for (size_t cell = 0; cell < mask->is_valid.size(); ++cell) {
    const Eigen::Vector2d center = mask->CellCenter(static_cast<int>(cell));
    for (const double dy : {-half, half})
      for (const double dx : {-half, half})
        if (!circle.Contains(center + Eigen::Vector2d(dx, dy)))
          mask->is_valid[cell] = false;
  }
}

}  // namespace raygrid
