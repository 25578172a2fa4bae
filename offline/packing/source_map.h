#ifndef RAYGRID_PACKING_SOURCE_MAP_H
#define RAYGRID_PACKING_SOURCE_MAP_H

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "camera/camera_model.h"
#include "packing/view.h"

namespace raygrid {

/// The image that a table fills: the direction in camera axes, of any length,
/// that a pixel looks along, and back; nothing where it looks nowhere.
struct OutputImage {
  ImageSize size;
  std::function<std::optional<Eigen::Vector3d>(const Eigen::Vector2d&)>
      direction;
  std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector3d&)> pixel;
  /// Pixels that look nowhere may show anything; otherwise they are border.
  bool is_free_where_unseen = false;
};

/// A view's own picture. The view, or below the camera, is referred to as long
/// as the result is used.
OutputImage OutputOfView(const VirtualView& view);
/// The real camera's image, for tables whose source is a view's picture.
OutputImage OutputOfCamera(const CameraModel& camera);

/// The sources of the pixels of an output image, the output pixels.
struct SourceMap {
  /// Cells are squares of output pixels.
  static constexpr int kCellLog2 = 3, kCellSize = 1 << kCellLog2;
  enum class Cell : uint8_t {
    kEmpty,    ///< no pixel's source is known
    kOutside,  ///< none of the sources lies in the rectangle
    kPartial,
    kWhole  ///< the sources of all pixels lie in the rectangle
  };
  static constexpr int kUnitsPerPx = 1 << 16;
  static constexpr int32_t kUnknown = INT32_MIN;

  int width = 0, height = 0;
  /// The numbers of cells. Cells at the right and lower edge may reach beyond
  /// the image, where no source is known.
  int columns = 0, rows = 0;
  /// Sources that count: within the calibrated area and the pixels' centres.
  /// Others are only known near it.
  Area rectangle;
  /// No source is farther off from the model's.
  double max_deviation_px = 0;
  /// The two coordinates of the sources, in units, row by row of whole cells.
  std::unique_ptr<int32_t[]> sources[2];
  std::vector<Cell> cells;
  /// Cells that are to be border although their sources are known.
  std::vector<bool> is_hidden;
  /// Cells at the edge of what the camera shows within the rectangle: they have
  /// a pixel without a source beside one whose source is not at the rectangle's
  /// edge. A table is border there, and may not interpolate across.
  std::vector<bool> is_cut_off;

  Cell& cell(int column, int row) { return cells[row * columns + column]; }
  Cell cell(int column, int row) const { return cells[row * columns + column]; }
  size_t Index(int x, int y) const {
    return static_cast<size_t>(y) * columns * kCellSize + x;
  }
  bool IsKnown(int x, int y) const {
    return sources[0][Index(x, y)] != kUnknown;
  }
  Eigen::Vector2d At(int x, int y) const {
    const size_t k = Index(x, y);
    return Eigen::Vector2d(sources[0][k], sources[1][k]) / kUnitsPerPx;
  }
  /// Whether a source is in the rectangle, or no farther from it than the map
  /// may be off.
  bool IsInside(const Eigen::Vector2d& source) const {
    return rectangle.Contains(source, max_deviation_px);
  }
};

/// The camera is asked at every eighth pixel of every eighth row, and between
/// these only where interpolation would not follow it to 0.002 px. The same
/// with any number of threads.
SourceMap MakeSourceMap(const CameraModel& camera, const OutputImage& output,
                        int num_threads);

/// The camera's own answer where the map knows a source.
std::optional<Eigen::Vector2d> ExactSource(const CameraModel& camera,
                                           const OutputImage& output,
                                           const SourceMap& map, int x, int y);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_SOURCE_MAP_H
