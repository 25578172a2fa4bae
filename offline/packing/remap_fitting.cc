#include "packing/remap_fitting.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <optional>

#include "cortex_m/part_corners.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "frames/lattice_map.h"
#include "frames/pixel_formats.h"
#include "packing/node_fitting.h"
#include "packing/remap_blocks.h"
#include "packing/remap_quantization.h"
#include "packing/source_map.h"

namespace raygrid {
namespace {

constexpr double kQ12 = 4096;

// Large parts, which remap faster, before small ones; then few bytes.
constexpr BlockLayout kLayouts[] = {{6, 5}, {5, 0}, {6, 4}, {5, 4}, {4, 0},
                                    {6, 3}, {5, 3}, {4, 3}, {3, 0}};

// Blocks are the border's grain where pixels are not shown.
constexpr int kMaxHidingLog2 = 4;

void FillFields(const ImageSize& source, const SourceMap& map,
                const VirtualView& view, const Blocks& blocks,
                RemapTable* table) {
  table->view = view;
  const Area& rectangle = map.rectangle;
  rg_remap_section& s = table->section;
  s.width = static_cast<uint16_t>(map.width);
  s.height = static_cast<uint16_t>(map.height);
  s.columns = static_cast<uint16_t>(blocks.columns + 1);
  s.rows = static_cast<uint16_t>(blocks.rows + 1);
  s.block_log2 = static_cast<uint8_t>(blocks.size_log2());
  s.part_log2 = static_cast<uint8_t>(blocks.layout.part_log2);
  s.min_x_q12 = static_cast<int32_t>(std::ceil(rectangle.x0 * kQ12));
  s.min_y_q12 = static_cast<int32_t>(std::ceil(rectangle.y0 * kQ12));
  s.max_x_q12 = static_cast<int32_t>(std::floor(rectangle.x1 * kQ12));
  s.max_y_q12 = static_cast<int32_t>(std::floor(rectangle.y1 * kQ12));
  s.fx_q16 = static_cast<uint32_t>(std::lround(view.focal_px.x() * 65536));
  s.fy_q16 = static_cast<uint32_t>(std::lround(view.focal_px.y() * 65536));
  s.cx_q16 = static_cast<int32_t>(std::lround(view.center_px.x() * 65536));
  s.cy_q16 = static_cast<int32_t>(std::lround(view.center_px.y() * 65536));
  s.projection = static_cast<uint8_t>(view.projection);
  s.has_view = view.projection != ViewProjection::kPinhole || view.IsTurned();
  s.direction = RG_UNDISTORT;
  s.source_width = static_cast<uint16_t>(source.width);
  s.source_height = static_cast<uint16_t>(source.height);
  for (int k = 0; k < 9; ++k)
    s.rotation_q30[k] = static_cast<int32_t>(
        std::lround(view.camera_from_view(k / 3, k % 3) * (1 << 30)));
  table->empty_blocks.assign((blocks.used.size() + 31) / 32 * 4, 0);
  for (size_t k = 0; k < blocks.used.size(); ++k)
    if (!blocks.used[k]) table->empty_blocks[k / 8] |= 1u << (k % 8);
}

// The section as a board will read it.
std::vector<uint32_t> SectionWords(const RemapTable& table) {
  rg_remap_section section = table.section;
  section.empty_blocks = table.empty_blocks.data();
  section.bends = table.bends.data();
  std::vector<uint32_t> words(rg_remap_section_size(&section) / 4);
  rg_write_remap(&section, table.residuals.data(),
                 reinterpret_cast<uint8_t*>(words.data()));
  return words;
}

// The error of an output pixel: the distance of its position from the exact
// one, which may be off by the margin; for a pixel without exact position, how
// far inside the rectangle the table puts it.
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

// The errors of a table, with the integers of the board.
class TableErrors {
 public:
  TableErrors(const CameraModel& camera, const OutputImage& output,
              const SourceMap& map, const Blocks& blocks,
              const RemapTable& table, int num_threads)
      : camera_(camera),
        output_(output),
        map_(map),
        blocks_(blocks),
        words_(SectionWords(table)),
        num_threads_(num_threads),
        part_(1 << blocks.layout.SmallestLog2()),
        num_part_rows_((map.height + part_ - 1) / part_) {}

  // The worst PixelError; nothing if it is above the limit. First by the map,
  // then by the camera for the pixels that may be the worst.
  std::optional<double> Worst(double limit_px) const {
    std::vector<double> worst(num_part_rows_, 0);
    std::atomic<bool> fails{false};
    ParallelFor(num_part_rows_, num_threads_, [&](int j) {
      if (fails) return;
      worst[j] = WorstOfPartRow(j);
      if (worst[j] - map_.max_deviation_px > limit_px) fails = true;
    });
    if (fails) return std::nullopt;
    const double about = *std::max_element(worst.begin(), worst.end());
    const double enough = about - 2 * map_.max_deviation_px;
    ParallelFor(num_part_rows_, num_threads_, [&](int j) {
      worst[j] = worst[j] >= enough ? ExactWorstOfPartRow(j, enough) : 0;
    });
    const double exact =
        std::max(about - map_.max_deviation_px,
                 *std::max_element(worst.begin(), worst.end()));
    if (exact > limit_px) return std::nullopt;
    return exact;
  }

 private:
  // Calls visit(x, block) for parts of a row of parts, with their first column.
  template <typename Visit>
  void ForParts(int j, const Visit& visit) const {
    const auto* section = reinterpret_cast<const uint8_t*>(words_.data());
    const int log2 = blocks_.layout.SmallestLog2();
    rg_part_row parts;
    rg_start_part_row(section, log2, log2, j, &parts);
    for (int x = 0; x < map_.width; x += part_) {
      rg_block block;
      rg_next_block(&parts, &block);
      if (!parts.is_empty) visit(x, block);
    }
  }

  // Calls visit(x, y, position) for the pixels of a part.
  template <typename Visit>
  void ForPixels(int x0, int y0, const rg_block& block,
                 const Visit& visit) const {
    for (int y = y0; y < std::min(y0 + part_, map_.height); ++y) {
      rg_block_row row;
      rg_find_block_row(&block, y - y0, &row);
      for (int x = x0; x < std::min(x0 + part_, map_.width); ++x) {
        const rg_position p = rg_row_position(&row, x - x0);
        visit(x, y, Eigen::Vector2d(p.q12[0] / kQ12, p.q12[1] / kQ12));
      }
    }
  }

  bool IsWhole(int x0, int y0) const {
    constexpr int kLog2 = SourceMap::kCellLog2;
    const int column = x0 >> kLog2, row = y0 >> kLog2, num = part_ >> kLog2;
    if (column + num > map_.columns || row + num > map_.rows) return false;
    for (int j = row; j < row + num; ++j)
      for (int i = column; i < column + num; ++i)
        if (map_.cell(i, j) != SourceMap::Cell::kWhole) return false;
    return true;
  }

  double WorstOfPartRow(int j) const {
    double worst = 0;
    ForParts(j, [&](int x0, const rg_block& block) {
      const int y0 = j * part_;
      if (IsWhole(x0, y0)) {
        worst = std::max(worst, WorstOfWholePart(x0, y0, block));
        return;
      }
      ForPixels(x0, y0, block,
                [&](int x, int y, const Eigen::Vector2d& position) {
                  worst = std::max(worst, ErrorByMap(x, y, position));
                });
    });
    return worst;
  }

  double ErrorByMap(int x, int y, const Eigen::Vector2d& position) const {
    const auto source =
        map_.IsKnown(x, y) ? std::optional(map_.At(x, y)) : std::nullopt;
    if (!source && output_.is_free_where_unseen &&
        !output_.direction(Eigen::Vector2d(x, y)))
      return 0;
    return PixelError(map_.rectangle, source, map_.max_deviation_px, position);
  }
  double ExactError(int x, int y, const Eigen::Vector2d& position) const {
    const auto source = map_.IsKnown(x, y)
                            ? ExactSource(camera_, output_, map_, x, y)
                            : std::nullopt;
    return PixelError(map_.rectangle, source, 0, position);
  }

  // The worst error of a part all of whose pixels have sources in the
  // rectangle.
  double WorstOfWholePart(int x0, int y0, const rg_block& block) const {
    constexpr int kLanes = SourceMap::kCellSize;
    using Integers = Eigen::Array<int32_t, kLanes, 1>;
    using Floats = Eigen::Array<float, kLanes, 1>;
    constexpr int kUnit = SourceMap::kUnitsPerPx / 4096;
    const Integers count = Integers::LinSpaced(0, kLanes - 1);
    Floats worst = Floats::Zero();
    for (int r = 0; r < part_; ++r) {
      rg_block_row row;
      rg_find_block_row(&block, r, &row);
      const size_t first = map_.Index(x0, y0 + r);
      for (int k = 0; k < part_; k += kLanes) {
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

  // The worst error of a row of parts, of the pixels that are enough off.
  double ExactWorstOfPartRow(int j, double enough) const {
    double worst = 0;
    ForParts(j, [&](int x0, const rg_block& block) {
      ForPixels(x0, j * part_, block,
                [&](int x, int y, const Eigen::Vector2d& position) {
                  if (ErrorByMap(x, y, position) >= enough)
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
  const int num_threads_, part_, num_part_rows_;
};

// The worst error of a lattice of chroma, by the map: a source is the mean of
// those of the output pixels that a sample stands for.
double WorstOfChroma(const SourceMap& map, const std::vector<uint32_t>& words,
                     const rg_lattice& lattice, int num_threads) {
  const auto* section = reinterpret_cast<const uint8_t*>(words.data());
  const uint32_t width_log2 = rg_part_log2(section, &lattice, 0);
  const uint32_t height_log2 = rg_part_log2(section, &lattice, 1);
  const int num_x = 1 << lattice.log2[0], num_y = 1 << lattice.log2[1];
  const Eigen::Vector2d half(lattice.half[0] / 2.0, lattice.half[1] / 2.0);
  const Eigen::Vector2d unit(num_x, num_y);
  // The sample's position in the lattice, if it counts.
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
  const int part_height = 1 << height_log2;
  std::vector<double> worst((map.height + part_height - 1) / part_height, 0);
  ParallelFor(static_cast<int>(worst.size()), num_threads, [&](int j) {
    rg_part_row parts;
    rg_start_part_row(section, width_log2, height_log2, j, &parts);
    for (int x0 = 0; x0 < map.width; x0 += 1 << width_log2) {
      rg_block block;
      rg_next_block(&parts, &block);
      if (parts.is_empty) continue;
      rg_lattice_block(&lattice, &block);
      for (int r = 0; r < 1 << block.height_log2; ++r) {
        rg_block_row row;
        rg_find_block_row(&block, r, &row);
        for (int k = 0; k < 1 << block.width_log2; ++k) {
          const auto exact =
              source(x0 + num_x * k, j * part_height + num_y * r);
          if (!exact) continue;
          const rg_position p = rg_row_position(&row, k);
          worst[j] = std::max(
              worst[j],
              (Eigen::Vector2d(p.q12[0], p.q12[1]) / kQ12 - *exact).norm());
        }
      }
    }
  });
  return *std::max_element(worst.begin(), worst.end());
}

double WorstOfChroma(const SourceMap& map, const RemapTable& table,
                     int num_threads) {
  const std::vector<uint32_t> words = SectionWords(table);
  double worst = 0;
  for (const rg_format format : {RG_FORMAT_NV12, RG_FORMAT_YUYV}) {
    rg_lattice lattice;
    rg_find_lattice(format, 1, &lattice);
    worst = std::max(worst, WorstOfChroma(map, words, lattice, num_threads));
  }
  return worst;
}

// No table with parts of a size has a smaller worst error: no bilinear function
// is closer to the sources at the corners, the edges' middles and the centre of
// each part.
double LeastError(const SourceMap& map, int part_log2) {
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
  // A row's step is rounded.
  const double rounding_px = half / kQ12 + map.max_deviation_px;
  return worst - rounding_px;
}

void RequireFormatLimits(const ImageSize& source, const ImageSize& output) {
  const int limit = RG_MAX_REMAP_SIZE;
  for (const ImageSize& size : {source, output})
    if (size.width < 1 || size.height < 1 || size.width > limit ||
        size.height > limit)
      throw Error(ExitCode::kUsage,
                  fmt::format("remap of {} x {} pixels: sizes are 1 to {}",
                              size.width, size.height, limit));
}

// The pixels of a camera's frames that are shown: those that are asked for, and
// that the lens throws light on. Nothing: all.
ShownPixels ShownOfCamera(const CameraModel& camera, const ShownPixels& asked) {
  if (!camera.image_circle()) return asked;
  return [&camera, asked](const Eigen::Vector2d& pixel) {
    return camera.IsLit(pixel) && (!asked || asked(pixel));
  };
}

// Hides cells no pixel of which is shown.
template <typename Shows>
void HideCells(const Shows& shows, SourceMap* map) {
  constexpr int kCell = SourceMap::kCellSize;
  for (int row = 0; row < map->rows; ++row) {
    for (int column = 0; column < map->columns; ++column) {
      bool is_shown = false;
      for (int k = 0; k < kCell * kCell && !is_shown; ++k) {
        const int x = column * kCell + k % kCell, y = row * kCell + k / kCell;
        is_shown = x < map->width && y < map->height && map->IsKnown(x, y) &&
                   shows(x, y);
      }
      map->is_hidden[row * map->columns + column] = !is_shown;
    }
  }
}

// One of several alike tables is made from this: an output image whose source
// is a camera's image, and which cells of its map are border.
struct TableInput {
  const CameraModel* camera;
  OutputImage output;
  std::function<void(SourceMap*)> hide;
};

// A table's input, and what does not depend on its blocks.
struct MappedInput {
  MappedInput(const TableInput& table, int num_threads)
      : input(table),
        map(MakeMap(table, num_threads)),
        sums(map, num_threads),
        has_hidden(std::find(map.is_hidden.begin(), map.is_hidden.end(),
                             true) != map.is_hidden.end()) {}

  const TableInput& input;
  const SourceMap map;
  const CellSums sums;
  const bool has_hidden;

 private:
  static SourceMap MakeMap(const TableInput& table, int num_threads) {
    SourceMap map = MakeSourceMap(*table.camera, table.output, num_threads);
    table.hide(&map);
    return map;
  }
};

// Moves nodes that a table lacks, where no block of it has a source, to where
// those of the nearest other table lie, by the affine map that is closest to
// how the two differ elsewhere.
void ContinueNodes(const Blocks& all, const std::vector<Blocks>& own,
                   size_t table, std::vector<NodePositions>* nodes) {
  const std::vector<bool> needed = NeededNodes(all);
  const std::vector<bool> here = NeededNodes(own[table]);
  if (here == needed) return;
  const auto basis = [&](int k) {
    return Eigen::Vector3d(1, k % (all.columns + 1), k / (all.columns + 1));
  };
  std::vector<bool> is_done = here;
  for (size_t apart = 1; apart < own.size(); ++apart) {
    for (const size_t other : {table - apart, table + apart}) {
      if (other >= own.size()) continue;
      const std::vector<bool> there = NeededNodes(own[other]);
      Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();
      Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
      for (int k = 0; k < all.num_vertices(); ++k) {
        if (!here[k] || !there[k]) continue;
        normal += basis(k) * basis(k).transpose();
        right += basis(k) * ((*nodes)[table].row(k) - (*nodes)[other].row(k));
      }
      const Eigen::Matrix<double, 3, 2> moved = normal.ldlt().solve(right);
      for (int k = 0; k < all.num_nodes(); ++k) {
        if (!needed[k] || is_done[k] || !there[k]) continue;
        is_done[k] = true;
        (*nodes)[table].row(k) = (*nodes)[other].row(k);
        if (k < all.num_vertices())
          (*nodes)[table].row(k) += basis(k).transpose() * moved;
      }
    }
  }
}

// The blocks in which any table has a source.
Blocks UnionOf(const std::vector<Blocks>& own) {
  Blocks all = own.front();
  for (const Blocks& blocks : own)
    for (size_t k = 0; k < all.used.size(); ++k)
      all.used[k] = all.used[k] || blocks.used[k];
  return all;
}

// Tables with blocks of a layout, as far as the format holds them; nothing if
// it does not.
std::optional<std::vector<RemapTable>> FitWithLayout(
    const std::vector<std::unique_ptr<MappedInput>>& inputs,
    const std::vector<Blocks>& own, const Blocks& all,
    const VirtualView& view) {
  std::vector<RemapTable> tables(inputs.size());
  std::vector<NodePositions> nodes;
  for (size_t t = 0; t < inputs.size(); ++t) {
    const MappedInput& input = *inputs[t];
    FillFields(input.input.camera->image_size(), input.map, view, all,
               &tables[t]);
    nodes.push_back(FitNodes(input.map, input.sums, own[t]));
  }
  for (size_t t = 0; t < inputs.size(); ++t) ContinueNodes(all, own, t, &nodes);
  if (!QuantizeVertices(all, nodes, &tables) ||
      !QuantizeBends(all, nodes, &tables))
    return std::nullopt;
  return tables;
}

// Measures a table in the blocks in which it has sources itself; false if it is
// off by more than the limit.
bool MeasureTable(const MappedInput& input, const Blocks& own,
                  double max_error_px, double limit_px, int num_threads,
                  RemapTable* table) {
  RemapTable measured = *table;
  FillFields(input.input.camera->image_size(), input.map, table->view, own,
             &measured);
  const TableErrors errors(*input.input.camera, input.input.output, input.map,
                           own, measured, num_threads);
  const std::optional<double> worst = errors.Worst(limit_px);
  if (!worst) return false;
  table->max_error_px = *worst;
  if (*worst > max_error_px) return false;
  table->max_chroma_error_px = WorstOfChroma(input.map, measured, num_threads);
  table->section.bound_upx =
      static_cast<uint32_t>(std::min(max_error_px * 1e6, 4e9));
  table->section.max_error_upx =
      static_cast<uint32_t>(std::ceil(table->max_error_px * 1e6));
  return true;
}

// Tables that are alike but for residuals, bends and errors; the view is what
// they are said to be of.
std::vector<RemapTable> FitTables(const std::vector<TableInput>& asked,
                                  const VirtualView& view, double max_error_px,
                                  int num_threads,
                                  const std::function<void()>& go_on) {
  num_threads = NumThreads(num_threads);
  std::vector<std::unique_ptr<MappedInput>> inputs;
  bool has_hidden = false;
  for (const TableInput& input : asked) {
    RequireFormatLimits(input.camera->image_size(), input.output.size);
    inputs.push_back(std::make_unique<MappedInput>(input, num_threads));
    has_hidden |= inputs.back()->has_hidden;
    go_on();
  }
  double worst_px = 0;
  for (const BlockLayout& layout : kLayouts) {
    go_on();
    if (has_hidden && layout.block_log2 > kMaxHidingLog2) continue;
    const bool is_last = &layout == std::end(kLayouts) - 1;
    if (!is_last &&
        std::any_of(inputs.begin(), inputs.end(), [&](const auto& input) {
          return LeastError(input->map, layout.SmallestLog2()) > max_error_px;
        }))
      continue;
    std::vector<Blocks> own;
    for (const auto& input : inputs)
      own.push_back(CutBlocks(input->map, layout));
    const Blocks all = UnionOf(own);
    if (std::count(all.used.begin(), all.used.end(), true) == 0)
      throw Error(
          ExitCode::kUsage,
          "the view sees nothing of the calibrated area; turn it there, or "
          "ask for a larger field of view");
    std::optional<std::vector<RemapTable>> tables =
        FitWithLayout(inputs, own, all, view);
    go_on();
    if (!tables) continue;
    bool are_good = true;
    for (size_t t = 0; t < inputs.size() && are_good; ++t) {
      are_good = MeasureTable(*inputs[t], own[t], max_error_px,
                              is_last ? INFINITY : max_error_px, num_threads,
                              &(*tables)[t]);
      worst_px = std::max(worst_px, (*tables)[t].max_error_px);
    }
    if (are_good) return *std::move(tables);
  }
  // More is no picture that anybody means.
  constexpr double kUsefulErrorPx = 1;
  throw Error(ExitCode::kQuality,
              fmt::format("the remap's geometric error is {:.3f} px with the "
                          "smallest blocks; {}",
                          worst_px,
                          worst_px <= kUsefulErrorPx
                              ? "allow that with --max-error-px, or ask for a "
                                "smaller field of view"
                              : "ask for a smaller field of view, or calibrate "
                                "again if the camera is no good there"));
}

}  // namespace

std::vector<RemapTable> FitRemapTables(
    const std::vector<const CameraModel*>& cameras, const VirtualView& view,
    double max_error_px, int num_threads, const std::function<void()>& go_on,
    const ShownPixels& asked) {
  std::vector<TableInput> inputs;
  for (const CameraModel* camera : cameras) {
    const ShownPixels shows = ShownOfCamera(*camera, asked);
    inputs.push_back(
        {camera, OutputOfView(view), [shows](SourceMap* map) {
           if (shows)
             HideCells([&](int x, int y) { return shows(map->At(x, y)); }, map);
         }});
  }
  return FitTables(inputs, view, max_error_px, num_threads, go_on);
}

std::vector<RemapTable> FitDistortionTables(
    const std::vector<const CameraModel*>& cameras, const VirtualView& view,
    double max_error_px, int num_threads, const std::function<void()>& go_on,
    const ShownPixels& asked) {
  const std::unique_ptr<CameraModel> turned = CameraOfTurnedView(view);
  std::vector<TableInput> inputs;
  for (const CameraModel* camera : cameras) {
    const ShownPixels shows = ShownOfCamera(*camera, asked);
    inputs.push_back(
        {turned.get(), OutputOfCamera(*camera), [shows](SourceMap* map) {
           if (shows)
             HideCells([&](int x, int y) { return shows({x, y}); }, map);
         }});
  }
  std::vector<RemapTable> tables =
      FitTables(inputs, view, max_error_px, num_threads, go_on);
  for (RemapTable& table : tables) {
    table.section.has_view = 1;
    table.section.direction = RG_DISTORT;
  }
  return tables;
}

}  // namespace raygrid
