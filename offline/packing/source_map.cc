#include "packing/source_map.h"

#include <algorithm>
#include <cmath>

#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

constexpr int kCell = SourceMap::kCellSize;
// The margin around the rectangle with sources, so that fits at its edge have
// samples on both sides.
constexpr double kMarginPx = 1.5;
// The interpolation error above which the camera model is evaluated.
constexpr double kMaxInterpolationErrorPx = 2e-3;
constexpr double kRoundingPx = 1.0 / SourceMap::kUnitsPerPx;  // at most

Area SourceRectangle(const CameraModel& camera) {
  const Area& area = camera.area();
  const Area image = WholeImage(camera.image_size());
  return {std::max(area.x0, image.x0), std::max(area.y0, image.y0),
          std::min(area.x1, image.x1), std::min(area.y1, image.y1)};
}

// Returns the source of an output pixel.
std::optional<Eigen::Vector2d> ComputeSource(const CameraModel& camera,
                                             const OutputImage& output,
                                             const Eigen::Vector2d& pixel,
                                             const Eigen::Vector2d* start,
                                             double margin_px) {
  const auto direction = output.direction(pixel);
  if (!direction) return std::nullopt;
  return camera.Project(*direction, start, margin_px);
}

// The sources of the cells' corners inside the rectangle, including two more
// rows and columns on each side of the image, and of two points around those.
// Computed by propagation from the centre, each point initialized with its
// neighbour's source, since a camera that folds maps some directions to two
// pixels.
class Lattice {
 public:
  Lattice(const CameraModel& camera, const OutputImage& output,
          const SourceMap& map)
      : camera_(camera),
        output_(output),
        rectangle_(map.rectangle),
        margin_px_(std::max(rectangle_.width(), rectangle_.height()) / 8),
        columns_(map.columns + 1 + 2 * kNeighborRadius),
        rows_(map.rows + 1 + 2 * kNeighborRadius),
        points_(static_cast<size_t>(columns_) * rows_) {
    StartFromSource(rectangle_.center());
    PropagateVisibility();
    StartFromImage();
    PropagateVisibility();
    StartFromSources();
    PropagateVisibility();
    AddNeighbors();
    ComputeInterpolationErrors();
  }

  // The upper left corner of a cell; NaN without a source.
  const Eigen::Vector2d& At(int column, int row) const {
    return points_[Index(column + kNeighborRadius, row + kNeighborRadius)]
        .source;
  }
  bool IsSeen(int column, int row) const {
    return points_[Index(column + kNeighborRadius, row + kNeighborRadius)]
        .is_seen;
  }
  // Returns the maximum interpolation error near a corner; NaN if unknown.
  double GetInterpolationError(int column, int row) const {
    return points_[Index(column + kNeighborRadius, row + kNeighborRadius)]
        .deviation;
  }

 private:
  static constexpr int kNeighborRadius = 2;
  struct Point {
    Eigen::Vector2d source = Eigen::Vector2d(NAN, NAN);
    double deviation = NAN;
    bool is_tried = false;
    bool is_seen = false;  // in the rectangle, or adjacent to such a point
  };

  int Index(int i, int j) const { return j * columns_ + i; }
  bool Contains(int i, int j) const {
    return i >= 0 && i < columns_ && j >= 0 && j < rows_;
  }

  void Try(int index, const Eigen::Vector2d* start) {
    Point& point = points_[index];
    if (point.is_tried) return;
    point.is_tried = true;
    const Eigen::Vector2d pixel((index % columns_ - kNeighborRadius) * kCell,
                                (index / columns_ - kNeighborRadius) * kCell);
    const auto source =
        ComputeSource(camera_, output_, pixel, start, margin_px_);
    if (source) point.source = *source;
  }

  void MarkVisible(int index) {
    if (points_[index].is_seen) return;
    points_[index].is_seen = true;
    seen_.push_back(index);
  }

  // Starts from the corners of the cell that contains a source.
  void StartFromSource(const Eigen::Vector2d& source) {
    const auto ray = camera_.Unproject(source);
    const auto pixel = ray ? output_.pixel(*ray) : std::nullopt;
    if (!pixel) return;
    const Eigen::Array2d cell =
        (pixel->array() / kCell).floor() + kNeighborRadius;
    if (!(cell >= 0).all() || !(cell.x() < columns_ - 1) ||
        !(cell.y() < rows_ - 1))
      return;
    for (int corner = 0; corner < 4; ++corner) {
      const int index = Index(static_cast<int>(cell.x()) + corner % 2,
                              static_cast<int>(cell.y()) + corner / 2);
      Try(index, &source);
      MarkVisible(index);
    }
  }

  // Starts from points between the rectangle's corners, which may be in thin
  // tips of the image, in case the visible part is not connected.
  void StartFromSources() {
    constexpr int kSteps = 32;
    for (int j = 0; j <= kSteps; ++j)
      for (int i = 0; i <= kSteps; ++i)
        StartFromSource({rectangle_.x0 + rectangle_.width() * i / kSteps,
                         rectangle_.y0 + rectangle_.height() * j / kSteps});
  }

  // Starts from the output image's corners and midpoints, in case it shows only
  // a small part of the rectangle.
  void StartFromImage() {
    for (int k = 0; k < 9; ++k) {
      const int index =
          Index(k % 3 * (columns_ - 1) / 2, k / 3 * (rows_ - 1) / 2);
      Try(index, nullptr);
      if (rectangle_.Contains(points_[index].source)) MarkVisible(index);
    }
  }

  // Calls visit(index) for the neighbours of a point.
  template <typename Visit>
  void ForEachNeighbor(int index, int distance, const Visit& visit) const {
    for (int j = -distance; j <= distance; ++j)
      for (int i = -distance; i <= distance; ++i)
        if (Contains(index % columns_ + i, index / columns_ + j))
          visit(index + Index(i, j));
  }

  void PropagateVisibility() {
    for (; num_propagated_ < seen_.size(); ++num_propagated_) {
      const Eigen::Vector2d from = points_[seen_[num_propagated_]].source;
      if (!from.allFinite()) continue;
      ForEachNeighbor(seen_[num_propagated_], 1, [&](int index) {
        Try(index, &from);
        // Accepts points that approach the rectangle.
        const Eigen::Vector2d& source = points_[index].source;
        if (rectangle_.Contains(source, (source - from).norm()))
          MarkVisible(index);
      });
    }
  }

  void AddNeighbors() {
    for (const int from : seen_) {
      const Eigen::Vector2d& start = points_[from].source;
      if (!start.allFinite()) continue;
      ForEachNeighbor(from, kNeighborRadius,
                      [&](int index) { Try(index, &start); });
    }
  }

  // Estimates the interpolation error: for constant fourth derivatives, cubic
  // interpolation between points with a fourth difference d has an error of at
  // most 3/128 d. 1/8 d is conservative for other functions, such as splines.
  void ComputeInterpolationErrors() {
    const auto fourth_difference = [&](int index, int step) {
      const auto at = [&](int k) -> const Eigen::Vector2d& {
        return points_[index + k * step].source;
      };
      return (at(-2) + at(2) - 4 * (at(-1) + at(1)) + 6 * at(0)).norm();
    };
    for (int j = kNeighborRadius; j < rows_ - kNeighborRadius; ++j)
      for (int i = kNeighborRadius; i < columns_ - kNeighborRadius; ++i)
        points_[Index(i, j)].deviation =
            (fourth_difference(Index(i, j), 1) +
             fourth_difference(Index(i, j), columns_)) /
            8;
  }

  const CameraModel& camera_;
  const OutputImage& output_;
  const Area rectangle_;
  const double margin_px_;
  const int columns_, rows_;
  std::vector<Point> points_;
  std::vector<int> seen_;
  size_t num_propagated_ = 0;  // number of processed elements of seen_
};

// Returns the maximum interpolation error in a cell; infinite where it cannot
// be interpolated, NaN where nothing is visible.
double ComputeCellInterpolationError(const Lattice& lattice, int column,
                                     int row) {
  double worst = -1;
  bool is_seen = false;
  for (int corner = 0; corner < 4; ++corner) {
    const int i = column + corner % 2, j = row + corner / 2;
    is_seen |= lattice.IsSeen(i, j);
    if (!std::isnan(lattice.GetInterpolationError(i, j)))
      worst = std::max(worst, lattice.GetInterpolationError(i, j));
  }
  if (!is_seen) return NAN;
  for (int j = row - 1; j <= row + 2; ++j)
    for (int i = column - 1; i <= column + 2; ++i)
      if (!lattice.At(i, j).allFinite()) return INFINITY;
  return worst >= 0 && worst <= kMaxInterpolationErrorPx ? worst : INFINITY;
}

// The weights of four values at consecutive corners for the positions between
// the inner two: cubic interpolation.
using Interpolation = Eigen::Matrix<double, kCell, 4>;
Interpolation MakeInterpolation() {
  Interpolation weights;
  for (int k = 0; k < kCell; ++k) {
    const double t = static_cast<double>(k) / kCell;
    weights.row(k) << -t * (t - 1) * (t - 2) / 6,
        (t + 1) * (t - 1) * (t - 2) / 2, -(t + 1) * t * (t - 2) / 2,
        (t + 1) * t * (t - 1) / 6;
  }
  return weights;
}

// The sources of a cell's pixels, by coordinate and row; NaN without a source.
struct CellSources {
  using Plane = Eigen::Matrix<double, kCell, kCell, Eigen::RowMajor>;
  Plane planes[2];

  Eigen::Vector2d At(int x, int y) const {
    return {planes[0](y, x), planes[1](y, x)};
  }
  void Set(int x, int y, const Eigen::Vector2d& source) {
    for (int axis = 0; axis < 2; ++axis) planes[axis](y, x) = source[axis];
  }
  bool AreAllInside(const Area& area) const {
    return IsBetween(planes[0], area.x0, area.x1) &&
           IsBetween(planes[1], area.y0, area.y1);
  }

 private:
  static bool IsBetween(const Plane& plane, double low, double high) {
    return plane.minCoeff<Eigen::PropagateNaN>() >= low &&
           plane.maxCoeff<Eigen::PropagateNaN>() <= high;
  }
};

CellSources InterpolateCell(const Lattice& lattice, int column, int row) {
  static const Interpolation weights = MakeInterpolation();
  CellSources sources;
  for (int axis = 0; axis < 2; ++axis) {
    Eigen::Matrix4d corners;
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i)
        corners(j, i) = lattice.At(column + i - 1, row + j - 1)[axis];
    const Eigen::Matrix<double, 4, kCell> across =
        corners.lazyProduct(weights.transpose());
    sources.planes[axis] = weights.lazyProduct(across);
  }
  return sources;
}

// Each projection is initialized with the previous result, or with the cell's
// corner.
CellSources ProjectCell(const CameraModel& camera, const OutputImage& output,
                        int column, int row, const Eigen::Vector2d& corner) {
  CellSources sources;
  Eigen::Vector2d start = corner;
  for (int y = 0; y < kCell; ++y) {
    for (int x = 0; x < kCell; ++x) {
      const Eigen::Vector2d pixel(column * kCell + x, row * kCell + y);
      const auto source =
          ComputeSource(camera, output, pixel,
                        start.allFinite() ? &start : nullptr, kMarginPx);
      if (source) start = *source;
      sources.Set(x, y, source.value_or(Eigen::Vector2d(NAN, NAN)));
    }
  }
  return sources;
}

// Rounds non-negative values.
int32_t ToUnits(double value_px) {
  return static_cast<int32_t>(value_px * SourceMap::kUnitsPerPx + 0.5);
}

void ClearCell(int column, int row, SourceMap* map) {
  for (auto& plane : map->sources)
    for (int y = 0; y < kCell; ++y)
      std::fill_n(&plane[map->Index(column * kCell, row * kCell + y)], kCell,
                  SourceMap::kUnknown);
  map->cell(column, row) = SourceMap::Cell::kEmpty;
}

void StoreInteriorCell(int column, int row, const CellSources& sources,
                       SourceMap* map) {
  for (int axis = 0; axis < 2; ++axis) {
    for (int y = 0; y < kCell; ++y) {
      int32_t* const units =
          &map->sources[axis][map->Index(column * kCell, row * kCell + y)];
      const double* const values_px = &sources.planes[axis](y, 0);
      for (int x = 0; x < kCell; ++x) units[x] = ToUnits(values_px[x]);
    }
  }
  map->cell(column, row) = SourceMap::Cell::kWhole;
}

void StoreCell(int column, int row, const CellSources& sources,
               SourceMap* map) {
  const int x0 = column * kCell, y0 = row * kCell;
  if (x0 + kCell <= map->width && y0 + kCell <= map->height &&
      sources.AreAllInside(map->rectangle)) {
    StoreInteriorCell(column, row, sources, map);
    return;
  }
  ClearCell(column, row, map);
  SourceMap::Cell& cell = map->cell(column, row);
  for (int y = y0; y < std::min(y0 + kCell, map->height); ++y) {
    for (int x = x0; x < std::min(x0 + kCell, map->width); ++x) {
      const Eigen::Vector2d source = sources.At(x - x0, y - y0);
      if (!map->rectangle.Contains(source, kMarginPx)) continue;
      for (int axis = 0; axis < 2; ++axis)
        map->sources[axis][map->Index(x, y)] =
            ToUnits(source[axis] + kMarginPx) - ToUnits(kMarginPx);
      cell = std::max(cell, map->IsInside(source) ? SourceMap::Cell::kPartial
                                                  : SourceMap::Cell::kOutside);
    }
  }
}

// Finds the cells where the image is cut off by the camera's area, not by the
// rectangle.
class CutOffSearch {
 public:
  CutOffSearch(const CameraModel& camera, const OutputImage& output,
               SourceMap* map)
      : camera_(camera), output_(output), map_(*map) {}

  // Marks the cells of a row of pixels.
  void MarkRow(int y) const {
    for (int x = 0; x < map_.width; ++x) {
      if (map_.IsKnown(x, y) || !IsCutOff(x, y)) continue;
      map_.is_cut_off[(y / kCell) * map_.columns + x / kCell] = true;
    }
  }

 private:
  bool Contains(int x, int y) const {
    return x >= 0 && x < map_.width && y >= 0 && y < map_.height;
  }

  bool IsCutOff(int x, int y) const {
    constexpr int kSteps[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    for (const auto& step : kSteps)
      if (Contains(x + step[0], y + step[1]) &&
          map_.IsKnown(x + step[0], y + step[1]) &&
          IsCutOffFrom(x, y, step[0], step[1]))
        return true;
    return false;
  }

  // Whether a pixel would be in the rectangle, like its neighbour, if the
  // camera were defined there.
  bool IsCutOffFrom(int x, int y, int dx, int dy) const {
    const Eigen::Vector2d beside = map_.At(x + dx, y + dy);
    const int far_x = x + 2 * dx, far_y = y + 2 * dy;
    const Eigen::Vector2d step =
        Contains(far_x, far_y) && map_.IsKnown(far_x, far_y)
            ? Eigen::Vector2d(beside - map_.At(far_x, far_y))
            : Eigen::Vector2d::Zero();
    if (!map_.rectangle.Contains(beside + step, kMarginPx)) return false;
    const Area& area = map_.rectangle;
    const double far_px = std::max(area.width(), area.height()) / 8;
    return !ComputeSource(camera_, output_, Eigen::Vector2d(x, y), &beside,
                          far_px);
  }

  const CameraModel& camera_;
  const OutputImage& output_;
  SourceMap& map_;
};

}  // namespace

OutputImage MakeViewOutput(const VirtualView& view) {
  return {
      view.size,
      [&view](const Eigen::Vector2d& pixel) { return view.Direction(pixel); },
      [&view](const Eigen::Vector3d& direction) {
        return view.Pixel(direction);
      }};
}

OutputImage MakeCameraOutput(const CameraModel& camera) {
  return {camera.image_size(),
          [&camera](const Eigen::Vector2d& pixel) {
            return camera.Unproject(pixel);
          },
          [&camera](const Eigen::Vector3d& direction) {
            return camera.Project(direction);
          },
          true};
}

SourceMap MakeSourceMap(const CameraModel& camera, const OutputImage& output,
                        int num_threads) {
  SourceMap map;
  map.width = output.size.width;
  map.height = output.size.height;
  map.columns = (map.width + kCell - 1) / kCell;
  map.rows = (map.height + kCell - 1) / kCell;
  map.rectangle = SourceRectangle(camera);
  map.cells.resize(static_cast<size_t>(map.columns) * map.rows);
  map.is_hidden.assign(map.cells.size(), false);
  for (auto& plane : map.sources)
    plane.reset(new int32_t[map.cells.size() * kCell * kCell]);

  const Lattice lattice(camera, output, map);
  std::vector<double> deviations;
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      deviations.push_back(ComputeCellInterpolationError(lattice, column, row));
      if (std::isfinite(deviations.back()))
        map.max_stddev_px = std::max(map.max_stddev_px, deviations.back());
    }
  }
  map.max_stddev_px += kRoundingPx;
  ParallelFor(map.rows, num_threads, [&](int row) {
    for (int column = 0; column < map.columns; ++column) {
      const double deviation = deviations[row * map.columns + column];
      if (std::isnan(deviation))
        ClearCell(column, row, &map);
      else if (std::isinf(deviation))
        StoreCell(
            column, row,
            ProjectCell(camera, output, column, row, lattice.At(column, row)),
            &map);
      else
        StoreCell(column, row, InterpolateCell(lattice, column, row), &map);
    }
  });
  map.is_cut_off.assign(map.cells.size(), false);
  if (!output.is_free_where_unseen) {
    const CutOffSearch search(camera, output, &map);
    for (int y = 0; y < map.height; ++y) search.MarkRow(y);
  }
  return map;
}

std::optional<Eigen::Vector2d> ExactSource(const CameraModel& camera,
                                           const OutputImage& output,
                                           const SourceMap& map, int x, int y) {
  const Eigen::Vector2d start = map.At(x, y);
  return ComputeSource(camera, output, Eigen::Vector2d(x, y), &start,
                       kMarginPx);
}

}  // namespace raygrid
