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

/// The output image of a table: the direction of a pixel in camera axes, of any
/// length, and the inverse; nullopt where undefined.
struct OutputImage {
  ImageSize size;
  std::function<std::optional<Eigen::Vector3d>(const Eigen::Vector2d&)>
      direction;
  std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector3d&)> pixel;
  /// If true, output pixels without a direction may have any value; if false,
  /// they are border.
  bool is_free_where_unseen = false;
};

/// Returns the undistorted image of a view as output. The view must outlive the
/// result.
OutputImage MakeViewOutput(const VirtualView& view);
/// Returns the camera's distorted image as output, for inverse remap tables,
/// whose sources are in the undistorted view. The camera must outlive the
/// result.
OutputImage MakeCameraOutput(const CameraModel& camera);

/// Source positions of the pixels of an output image.
struct SourceMap {
  /// Cells are squares of output pixels.
  static constexpr int kCellLog2 = 3, kCellSize = 1 << kCellLog2;
  enum class Cell : uint8_t {
    kEmpty,    ///< no pixel has a source
    kOutside,  ///< no source is in the rectangle
    kPartial,
    kWhole  ///< all sources are in the rectangle
  };
  static constexpr int kUnitsPerPx = 1 << 16;
  static constexpr int32_t kUnknown = INT32_MIN;

  int width = 0, height = 0;
  /// Numbers of cells. Cells at the right and lower edge may extend beyond the
  /// image, where there is no source.
  int columns = 0, rows = 0;
  /// Rectangle of usable sources: within the calibrated area and the pixel
  /// centres. Other sources are defined only near it.
  Area rectangle;
  /// Maximum error of interpolated sources (px).
  double max_stddev_px = 0;
  /// Both coordinates of the sources, in units, row by row of whole cells.
  std::unique_ptr<int32_t[]> sources[2];
  std::vector<Cell> cells;
  /// Cells that become border although they have sources, because none of their
  /// pixels is to be shown.
  std::vector<bool> is_hidden;
  /// Cells at the edge of the camera's valid pixels within the rectangle: they
  /// have a pixel without a source next to one whose source is not at the
  /// rectangle's edge. A table has border there, and must not interpolate
  /// across.
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
  /// Whether a source is in the rectangle, within the map's deviation.
  bool IsInside(const Eigen::Vector2d& source) const {
    return rectangle.Contains(source, max_stddev_px);
  }
};

/// Computes the sources: evaluates the camera at every eighth pixel of every
/// eighth row, and between them only where interpolation deviates by more than
/// 0.002 px. Deterministic for any number of threads.
SourceMap MakeSourceMap(const CameraModel& camera, const OutputImage& output,
                        int num_threads);

/// Evaluates the camera itself; nullopt where the map has no source.
std::optional<Eigen::Vector2d> ExactSource(const CameraModel& camera,
                                           const OutputImage& output,
                                           const SourceMap& map, int x, int y);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_SOURCE_MAP_H
