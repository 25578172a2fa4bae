#include "simulation/ink_map.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

constexpr double kMaxCells = 4e6;
// Lengths in units of cells. Edges within kKnown of a cell's centre are stored
// in the cell; patches in the cell, whose centres are up to 0.71 from the
// cell's centre, can only touch edges within kReach.
constexpr double kReach = 1.5, kKnown = 1.56;
constexpr double kMaxPatchRadius = 0.75;
// Distance from an edge where the colours of its sides are sampled; less than
// kKnown - kReach.
constexpr double kSideOffset = 0.05;
constexpr double kSameLine = 1e-6;
// Patches with several edges are divided into kParts x kParts parts.
constexpr int kParts = 4;
constexpr int kMaxSubdivisions = 32;

double DistanceToSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                         const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double t =
      std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (a + t * along - p).norm();
}

}  // namespace

double Footprint::ComputeFractionBeyondLine(const Eigen::Vector2d& normal,
                                            double distance_m) const {
  const Eigen::Vector2d slope = sides_m_.transpose() * normal;
  const double longer = std::max(std::abs(slope.x()), std::abs(slope.y()));
  const double shorter = std::min(std::abs(slope.x()), std::abs(slope.y()));
  const double reach = (longer + shorter) / 2;
  const double distance = std::abs(distance_m);
  double far_fraction = 0;  // fraction of the patch beyond the line
  if (distance <= (longer - shorter) / 2) {
    far_fraction = longer > 0 ? 0.5 - distance / longer : 0.5;
  } else if (distance < reach) {
    far_fraction =
        (reach - distance) * (reach - distance) / (2 * longer * shorter);
  }
  return distance_m > 0 ? 1 - far_fraction : far_fraction;
}

InkMap::InkMap(const BoardAppearance& appearance) : appearance_(appearance) {
  const Area& extent = appearance.extent_m();
  cell_m_ = std::sqrt(extent.width() * extent.height() / kMaxCells);
  corner_m_ = Eigen::Vector2d(extent.x0, extent.y0).array() - 2.5 * cell_m_;
  columns_ = static_cast<int>(std::ceil(extent.width() / cell_m_)) + 5;
  rows_ = static_cast<int>(std::ceil(extent.height() / cell_m_)) + 5;
  cells_.assign(static_cast<size_t>(columns_) * rows_, kEmpty);
  for (const InkLayer& layer : appearance.Layers())
    for (const Polygon& polygon : layer.polygons)
      for (size_t i = 0; i < polygon.size(); ++i)
        AddEdge(polygon[i], polygon[(i + 1) % polygon.size()]);
  ColorCells();
}

Eigen::Vector2d InkMap::CellCenter(int column, int row) const {
  return corner_m_ + Eigen::Vector2d(column + 0.5, row + 0.5) * cell_m_;
}

void InkMap::AddEdge(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  if (along.norm() < 1e-9 * cell_m_) return;
  const Eigen::Vector2d normal =
      Eigen::Vector2d(-along.y(), along.x()).normalized();
  edges_.push_back({normal, normal.dot(a)});
  const int32_t edge = static_cast<int32_t>(edges_.size()) - 1;
  const double known_m = kKnown * cell_m_;
  const auto get_row = [&](double y_m) {
    return std::clamp(
        static_cast<int>(std::floor((y_m - corner_m_.y()) / cell_m_)), 0,
        rows_ - 1);
  };
  const int last_row = get_row(std::max(a.y(), b.y()) + known_m);
  for (int row = get_row(std::min(a.y(), b.y()) - known_m); row <= last_row;
       ++row) {
    // Range of the edge parameter that can be near this row.
    double t0 = 0, t1 = 1;
    if (std::abs(along.y()) > 1e-3 * cell_m_) {
      const double y_m = CellCenter(0, row).y();
      t0 = (y_m - known_m - a.y()) / along.y();
      t1 = (y_m + known_m - a.y()) / along.y();
      if (t0 > t1) std::swap(t0, t1);
      t0 = std::clamp(t0, 0.0, 1.0);
      t1 = std::clamp(t1, 0.0, 1.0);
    }
    const double x0_m = a.x() + t0 * along.x(), x1_m = a.x() + t1 * along.x();
    const double first_m = std::min(x0_m, x1_m) - known_m - corner_m_.x();
    const double last_m = std::max(x0_m, x1_m) + known_m - corner_m_.x();
    const int first = std::max(0, static_cast<int>(first_m / cell_m_) - 1);
    const int last = std::min(columns_ - 1, static_cast<int>(last_m / cell_m_));
    for (int column = first; column <= last; ++column)
      if (DistanceToSegment(CellCenter(column, row), a, b) <= known_m)
        MarkCell(column, row, edge);
  }
}

void InkMap::MarkCell(int column, int row, int32_t edge) {
  int32_t& cell = cells_[static_cast<size_t>(row) * columns_ + column];
  if (cell == kEmpty) {
    cell = edge;
    return;
  }
  if (cell == kMultipleEdges) return;
  const Edge& known = edges_[cell];
  const Edge& added = edges_[edge];
  const double cosine = known.normal.dot(added.normal);
  const Eigen::Vector2d center = CellCenter(column, row);
  const double known_m = known.normal.dot(center) - known.offset;
  const double added_m = added.normal.dot(center) - added.offset;
  const bool is_same_line =
      std::abs(std::abs(cosine) - 1) < kSameLine * kSameLine &&
      std::abs(known_m - std::copysign(1.0, cosine) * added_m) <
          kSameLine * cell_m_;
  if (!is_same_line) cell = kMultipleEdges;
}

int32_t InkMap::ColorCell(const Eigen::Vector2d& point_m) const {
  // Cell centres may lie exactly on the border, where there is no ink without
  // an edge; but BoardAppearance's squares are half-open.
  if (!appearance_.extent_m().Contains(point_m, -1e-6 * cell_m_)) return kWhite;
  return appearance_.IsBlack(point_m) ? kBlack : kWhite;
}

void InkMap::ColorCells() {
  const int32_t num_edges = static_cast<int32_t>(edges_.size());
  for (int32_t i = 0; i < num_edges; ++i) edges_.push_back(edges_[i]);
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      int32_t& cell = cells_[static_cast<size_t>(row) * columns_ + column];
      if (cell == kMultipleEdges) continue;
      const Eigen::Vector2d center = CellCenter(column, row);
      if (cell == kEmpty) {
        cell = ColorCell(center);
        continue;
      }
      const Edge& edge = edges_[cell];
      const double distance_m = edge.normal.dot(center) - edge.offset;
      if (std::abs(distance_m) > kReach * cell_m_) {
        cell = ColorCell(center);
        continue;
      }
      const Eigen::Vector2d foot = center - distance_m * edge.normal;
      const Eigen::Vector2d beside = kSideOffset * cell_m_ * edge.normal;
      const int32_t beyond = ColorCell(foot + beside);
      if (beyond == ColorCell(foot - beside)) {
        cell = beyond;
      } else if (beyond == kBlack) {
        cell += num_edges;
      }
    }
  }
}

int32_t InkMap::CellAt(const Eigen::Vector2d& point_m) const {
  const Eigen::Vector2d cell = (point_m - corner_m_) / cell_m_;
  if (!(cell.x() >= 0 && cell.y() >= 0 && cell.x() < columns_ &&
        cell.y() < rows_))
    return kWhite;
  return cells_[static_cast<size_t>(static_cast<int>(cell.y())) * columns_ +
                static_cast<int>(cell.x())];
}

double InkMap::ComputePatchInk(const Eigen::Vector2d& center_m,
                               const Footprint& part, int32_t cell) const {
  if (cell == kWhite) return 0;
  if (cell == kBlack) return 1;
  if (cell == kMultipleEdges) return ColorCell(center_m) == kBlack ? 1 : 0;
  const Edge& edge = edges_[cell];
  const double beyond = part.ComputeFractionBeyondLine(
      edge.normal, edge.normal.dot(center_m) - edge.offset);
  const bool is_black_outside = cell >= static_cast<int32_t>(edges_.size() / 2);
  return is_black_outside ? beyond : 1 - beyond;
}

double InkMap::ComputeSubdividedInk(const Eigen::Vector2d& center_m,
                                    const Footprint& footprint,
                                    int patches_along_side) const {
  const Footprint part(footprint.sides_m() / patches_along_side);
  double sum = 0;
  for (int j = 0; j < patches_along_side; ++j) {
    for (int i = 0; i < patches_along_side; ++i) {
      const Eigen::Vector2d position(i, j);
      const Eigen::Vector2d at =
          center_m +
          part.sides_m() *
              (position.array() - (patches_along_side - 1) / 2.0).matrix();
      sum += ComputePatchInk(at, part, CellAt(at));
    }
  }
  return sum / (patches_along_side * patches_along_side);
}

double InkMap::InkFraction(const Eigen::Vector2d& center_m,
                           const Footprint& footprint) const {
  const double radius = footprint.radius_m() / cell_m_;
  if (radius > kMaxPatchRadius)
    return ComputeSubdividedInk(
        center_m, footprint,
        static_cast<int>(std::min(std::ceil(radius / kMaxPatchRadius),
                                  1.0 * kMaxSubdivisions)));
  const int32_t cell = CellAt(center_m);
  if (cell == kMultipleEdges)
    return ComputeSubdividedInk(center_m, footprint, kParts);
  return ComputePatchInk(center_m, footprint, cell);
}

}  // namespace raygrid
