#include "packing/remap_error.h"

#include <Eigen/Core>
#include <algorithm>
#include <atomic>
#include <cmath>

#include "dataset/parallel_for.h"
#include "frames/table_positions.h"

namespace raygrid {
namespace {

constexpr double kPositionUnits = 4096;  // the runtime's positions are q12

// Encodes the section as the runtime reads it.
std::vector<uint32_t> EncodeSection(const RemapTable& table) {
  rg_remap_section section = table.section;
  section.empty_blocks = table.empty_blocks.data();
  section.bends = table.bends.data();
  std::vector<uint32_t> words(rg_remap_section_size(&section) / 4);
  rg_write_remap(&section, table.residuals.data(),
                 reinterpret_cast<uint8_t*>(words.data()));
  return words;
}

// Returns the error of an output pixel: the distance of its position from the
// exact one, which may be uncertain by the margin; for a pixel without exact
// position, how far inside the rectangle the table's position is.
double PixelError(const Area& rectangle,
                  const std::optional<Eigen::Vector2d>& exact, double margin_px,
                  const Eigen::Vector2d& position) {
  const bool taken = rectangle.Contains(position);
  if (exact)
    return taken || rectangle.Contains(*exact, margin_px)
               ? (position - *exact).norm()
               : 0;
  if (!taken) return 0;
  const Eigen::Vector2d inside(
      std::min(position.x() - rectangle.x0, rectangle.x1 - position.x()),
      std::min(position.y() - rectangle.y0, rectangle.y1 - position.y()));
  return std::max(1.0, inside.minCoeff());
}

// The errors of a table, in the runtime's integer arithmetic.
class TableErrorMeter {
 public:
  TableErrorMeter(const CameraModel& camera, const OutputImage& output,
                  const SourceMap& map, const Blocks& blocks,
                  const RemapTable& table, int num_threads)
      : camera_(camera),
        output_(output),
        map_(map),
        blocks_(blocks),
        words_(EncodeSection(table)),
        num_threads_(num_threads),
        tile_size_(1 << blocks.layout.MinSizeLog2()),
        num_tile_rows_((map.height + tile_size_ - 1) / tile_size_) {}

  // Returns the maximum PixelError; nullopt if it exceeds the limit. It is
  // first evaluated from the source map, then from the camera for candidates of
  // the maximum.
  std::optional<double> FindMaxError(double limit_px) const {
    std::vector<double> worst(num_tile_rows_, 0);
    std::atomic<bool> exceeds_limit{false};
    ParallelFor(num_tile_rows_, num_threads_, [&](int j) {
      if (exceeds_limit) return;
      worst[j] = ComputeTileRowMaxError(j);
      if (worst[j] - map_.max_stddev_px > limit_px) exceeds_limit = true;
    });
    if (exceeds_limit) return std::nullopt;
    const double about = *std::max_element(worst.begin(), worst.end());
    const double enough = about - 2 * map_.max_stddev_px;
    ParallelFor(num_tile_rows_, num_threads_, [&](int j) {
      worst[j] =
          worst[j] >= enough ? ComputeExactTileRowMaxError(j, enough) : 0;
    });
    const double exact =
        std::max(about - map_.max_stddev_px,
                 *std::max_element(worst.begin(), worst.end()));
    if (exact > limit_px) return std::nullopt;
    return exact;
  }

  // Returns whether the error of each tile exceeds the limit, row by row.
  std::vector<bool> FindBlocksAbove(double limit_px) const {
    const int num_columns = (map_.width + tile_size_ - 1) / tile_size_;
    std::vector<uint8_t> is_beyond(
        static_cast<size_t>(num_columns) * num_tile_rows_, 0);
    ParallelFor(num_tile_rows_, num_threads_, [&](int j) {
      ForEachTileError(j, [&](int x0, double error_px) {
        is_beyond[j * num_columns + x0 / tile_size_] =
            error_px + map_.max_stddev_px > limit_px;
      });
    });
    return {is_beyond.begin(), is_beyond.end()};
  }

 private:
  // Calls visit(x, block) for the tiles of a row, with their first column.
  template <typename Visit>
  void ForEachTile(int j, const Visit& visit) const {
    const auto* section = reinterpret_cast<const uint8_t*>(words_.data());
    const int log2 = blocks_.layout.MinSizeLog2();
    rg_tile_row parts;
    rg_init_tile_row(section, log2, log2, j, &parts);
    for (int x = 0; x < map_.width; x += tile_size_) {
      rg_block block;
      rg_next_block(&parts, &block);
      if (!parts.is_block_empty) visit(x, block);
    }
  }

  // Calls visit(x, y, position) for the pixels of a tile.
  template <typename Visit>
  void ForEachPixel(int x0, int y0, const rg_block& block,
                    const Visit& visit) const {
    for (int y = y0; y < std::min(y0 + tile_size_, map_.height); ++y) {
      rg_block_row row;
      rg_compute_block_row(&block, y - y0, &row);
      for (int x = x0; x < std::min(x0 + tile_size_, map_.width); ++x) {
        const rg_position p = rg_row_position(&row, x - x0);
        visit(x, y,
              Eigen::Vector2d(p.q12[0] / kPositionUnits,
                              p.q12[1] / kPositionUnits));
      }
    }
  }

  bool IsWhole(int x0, int y0) const {
    constexpr int kLog2 = SourceMap::kCellLog2;
    const int column = x0 >> kLog2, row = y0 >> kLog2,
              num = tile_size_ >> kLog2;
    if (column + num > map_.columns || row + num > map_.rows) return false;
    for (int j = row; j < row + num; ++j)
      for (int i = column; i < column + num; ++i)
        if (map_.cell(i, j) != SourceMap::Cell::kWhole) return false;
    return true;
  }

  // Calls visit(x0, worst) for each tile of a row.
  template <typename Visit>
  void ForEachTileError(int j, const Visit& visit) const {
    ForEachTile(j, [&](int x0, const rg_block& block) {
      const int y0 = j * tile_size_;
      if (IsWhole(x0, y0)) {
        visit(x0, ComputeTileMaxError(x0, y0, block));
        return;
      }
      double worst = 0;
      ForEachPixel(x0, y0, block,
                   [&](int x, int y, const Eigen::Vector2d& position) {
                     worst = std::max(worst, ComputeMapError(x, y, position));
                   });
      visit(x0, worst);
    });
  }

  double ComputeTileRowMaxError(int j) const {
    double worst = 0;
    ForEachTileError(
        j, [&](int, double error_px) { worst = std::max(worst, error_px); });
    return worst;
  }

  double ComputeMapError(int x, int y, const Eigen::Vector2d& position) const {
    const auto source =
        map_.IsKnown(x, y) ? std::optional(map_.At(x, y)) : std::nullopt;
    if (!source && output_.is_free_where_unseen &&
        !output_.direction(Eigen::Vector2d(x, y)))
      return 0;
    return PixelError(map_.rectangle, source, map_.max_stddev_px, position);
  }
  double ExactError(int x, int y, const Eigen::Vector2d& position) const {
    const auto source = map_.IsKnown(x, y)
                            ? ExactSource(camera_, output_, map_, x, y)
                            : std::nullopt;
    return PixelError(map_.rectangle, source, 0, position);
  }

  // Returns the maximum error of a tile whose pixels all have sources in the
  // rectangle.
  double ComputeTileMaxError(int x0, int y0, const rg_block& block) const {
    constexpr int kLanes = SourceMap::kCellSize;
    using Integers = Eigen::Array<int32_t, kLanes, 1>;
    using Floats = Eigen::Array<float, kLanes, 1>;
    constexpr int kUnit = SourceMap::kUnitsPerPx / 4096;
    const Integers count = Integers::LinSpaced(0, kLanes - 1);
    Floats worst = Floats::Zero();
    for (int r = 0; r < tile_size_; ++r) {
      rg_block_row row;
      rg_compute_block_row(&block, r, &row);
      const size_t first = map_.Index(x0, y0 + r);
      for (int k = 0; k < tile_size_; k += kLanes) {
        Floats square = Floats::Zero();
        for (int axis = 0; axis < 2; ++axis) {
          const int32_t step = row.step.q12[axis] * kUnit;
          const int32_t start = row.start.q12[axis] * kUnit + k * step;
          const Eigen::Map<const Integers> source(
              &map_.sources[axis][first + k]);
          square += (count * step + start - source).cast<float>().square();
        }
        worst = worst.max(square);
      }
    }
    return std::sqrt(static_cast<double>(worst.maxCoeff())) /
           SourceMap::kUnitsPerPx;
  }

  // Returns the maximum error of a row of tiles, over pixels above a threshold.
  double ComputeExactTileRowMaxError(int j, double enough) const {
    double worst = 0;
    ForEachTile(j, [&](int x0, const rg_block& block) {
      ForEachPixel(x0, j * tile_size_, block,
                   [&](int x, int y, const Eigen::Vector2d& position) {
                     if (ComputeMapError(x, y, position) >= enough)
                       worst = std::max(worst, ExactError(x, y, position));
                   });
    });
    return worst;
  }

  const CameraModel& camera_;
  const OutputImage& output_;
  const SourceMap& map_;
  const Blocks& blocks_;
  const std::vector<uint32_t> words_;
  const int num_threads_, tile_size_, num_tile_rows_;
};

// Returns the maximum error of a chroma component, from the source map: the
// source of a sample is the mean of those of its output pixels.
double ComputeChromaMaxError(const SourceMap& map,
                             const std::vector<uint32_t>& words,
                             const rg_component& lattice, int num_threads) {
  const auto* section = reinterpret_cast<const uint8_t*>(words.data());
  const uint32_t width_log2 = rg_tile_log2(section, &lattice, 0);
  const uint32_t height_log2 = rg_tile_log2(section, &lattice, 1);
  const int num_x = 1 << lattice.log2[0], num_y = 1 << lattice.log2[1];
  const Eigen::Vector2d half(lattice.half[0] / 2.0, lattice.half[1] / 2.0);
  const Eigen::Vector2d unit(num_x, num_y);
  // The source of the chroma sample, if all of its pixels have one.
  const auto source = [&](int x, int y) -> std::optional<Eigen::Vector2d> {
    Eigen::Vector2d sum(0, 0);
    for (int j = y; j < y + num_y; ++j) {
      for (int i = x; i < x + num_x; ++i) {
        if (i >= map.width || j >= map.height || !map.IsKnown(i, j) ||
            !map.rectangle.Contains(map.At(i, j)))
          return std::nullopt;
        sum += map.At(i, j);
      }
    }
    return (sum / (num_x * num_y) - half).cwiseQuotient(unit);
  };
  const int tile_height = 1 << height_log2;
  std::vector<double> worst((map.height + tile_height - 1) / tile_height, 0);
  ParallelFor(static_cast<int>(worst.size()), num_threads, [&](int j) {
    rg_tile_row parts;
    rg_init_tile_row(section, width_log2, height_log2, j, &parts);
    for (int x0 = 0; x0 < map.width; x0 += 1 << width_log2) {
      rg_block block;
      rg_next_block(&parts, &block);
      if (parts.is_block_empty) continue;
      rg_transform_block(&lattice, &block);
      for (int r = 0; r < 1 << block.height_log2; ++r) {
        rg_block_row row;
        rg_compute_block_row(&block, r, &row);
        for (int k = 0; k < 1 << block.width_log2; ++k) {
          const auto exact =
              source(x0 + num_x * k, j * tile_height + num_y * r);
          if (!exact) continue;
          const rg_position p = rg_row_position(&row, k);
          worst[j] = std::max(
              worst[j],
              (Eigen::Vector2d(p.q12[0], p.q12[1]) / kPositionUnits - *exact)
                  .norm());
        }
      }
    }
  });
  return *std::max_element(worst.begin(), worst.end());
}

}  // namespace

std::optional<double> ComputeMaxRemapError(const CameraModel& camera,
                                           const OutputImage& output,
                                           const SourceMap& map,
                                           const Blocks& blocks,
                                           const RemapTable& table,
                                           double limit_px, int num_threads) {
  return TableErrorMeter(camera, output, map, blocks, table, num_threads)
      .FindMaxError(limit_px);
}

std::vector<bool> FindBlocksAboveError(const CameraModel& camera,
                                       const OutputImage& output,
                                       const SourceMap& map,
                                       const Blocks& blocks,
                                       const RemapTable& table, double limit_px,
                                       int num_threads) {
  return TableErrorMeter(camera, output, map, blocks, table, num_threads)
      .FindBlocksAbove(limit_px);
}

double ComputeMaxChromaError(const SourceMap& map, const RemapTable& table,
                             int num_threads) {
  const std::vector<uint32_t> words = EncodeSection(table);
  double worst = 0;
  for (const rg_format format : {RG_FORMAT_NV12, RG_FORMAT_YUYV}) {
    rg_component lattice;
    rg_get_component(format, 1, &lattice);
    worst = std::max(worst,
                     ComputeChromaMaxError(map, words, lattice, num_threads));
  }
  return worst;
}

double ComputeMinRemapError(const SourceMap& map, int part_log2) {
  const int part = 1 << part_log2, half = part / 2;
  double worst = 0;
  for (int y0 = 0; y0 + part < map.height; y0 += part) {
    for (int x0 = 0; x0 + part < map.width; x0 += part) {
      bool are_inside = true;
      Eigen::Vector2d at[3][3];
      for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i) {
          const int x = x0 + i * half, y = y0 + j * half;
          at[j][i] = map.At(x, y);
          are_inside &= map.IsKnown(x, y) && map.rectangle.Contains(at[j][i]);
        }
      }
      if (!are_inside) continue;
      const Eigen::Vector2d corners =
          (at[0][0] + at[0][2] + at[2][0] + at[2][2]) / 4;
      worst =
          std::max({worst, (corners - at[1][1]).norm() / 2,
                    (at[0][1] + at[2][1] - at[1][0] - at[1][2]).norm() / 4});
    }
  }
  // Subtracts the effect of rounding a row's step.
  const double rounding_px = half / kPositionUnits + map.max_stddev_px;
  return worst - rounding_px;
}

}  // namespace raygrid
