#include "packing/remap_fitting.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "packing/node_fitting.h"
#include "packing/remap_blocks.h"
#include "packing/remap_error.h"
#include "packing/remap_quantization.h"
#include "packing/source_map.h"

namespace raygrid {
namespace {

constexpr double kQ12 = 4096;

// Large tiles, which are faster to remap, before small ones; then small
// sections.
constexpr BlockLayout kLayouts[] = {{6, 5}, {5, 0}, {6, 4}, {5, 4}, {4, 0},
                                    {6, 3}, {5, 3}, {4, 3}, {3, 0}};

// The maximum block size if pixels are hidden, since the border has the
// resolution of blocks.
constexpr int kMaxExcludedBlockLog2 = 4;

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

void RequireFormatLimits(const ImageSize& source, const ImageSize& output) {
  const int limit = RG_MAX_REMAP_SIZE;
  for (const ImageSize& size : {source, output})
    if (size.width < 1 || size.height < 1 || size.width > limit ||
        size.height > limit)
      throw Error(
          ExitCode::kUsage,
          fmt::format(
              "remap of {} x {} pixels: width and height must be 1 to {}",
              size.width, size.height, limit));
}

// Returns the pixels of a camera's frames that tables show: the requested ones
// within the image circle. Empty: all pixels.
PixelFilter SelectCameraPixels(const CameraModel& camera,
                               const PixelFilter& asked) {
  if (!camera.image_circle()) return asked;
  return [&camera, asked](const Eigen::Vector2d& pixel) {
    return camera.IsInImageCircle(pixel) && (!asked || asked(pixel));
  };
}

// Hides cells without any shown pixel.
template <typename IsVisible>
void MarkHiddenCells(const IsVisible& shows, SourceMap* map) {
  constexpr int kCell = SourceMap::kCellSize;
  for (int row = 0; row < map->rows; ++row) {
    for (int column = 0; column < map->columns; ++column) {
      bool is_visible = false;
      for (int k = 0; k < kCell * kCell && !is_visible; ++k) {
        const int x = column * kCell + k % kCell, y = row * kCell + k / kCell;
        is_visible = x < map->width && y < map->height && map->IsKnown(x, y) &&
                     shows(x, y);
      }
      map->is_hidden[row * map->columns + column] = !is_visible;
    }
  }
}

// The input for one of several tables of equal layout: an output image whose
// source is a camera's image, and which cells of its map are border.
struct TableInput {
  const CameraModel* camera;
  OutputImage output;
  std::function<void(SourceMap*)> hide;
};

// A table's input, and precomputed data that does not depend on its blocks.
struct MappedInput {
  MappedInput(const TableInput& table, int num_threads)
      : input(table),
        map(MakeMap(table, num_threads)),
        sums(map, num_threads),
        has_hidden(ContainsTrue(map.is_hidden) ||
                   ContainsTrue(map.is_cut_off)) {}

  const TableInput& input;
  const SourceMap map;
  const CellSums sums;
  const bool has_hidden;

 private:
  static bool ContainsTrue(const std::vector<bool>& cells) {
    return std::find(cells.begin(), cells.end(), true) != cells.end();
  }
  static SourceMap MakeMap(const TableInput& table, int num_threads) {
    SourceMap map = MakeSourceMap(*table.camera, table.output, num_threads);
    table.hide(&map);
    return map;
  }
};

// Extrapolates nodes that none of a table's used blocks determine, from those
// of the nearest other table, by the affine map that best fits their
// differences elsewhere.
void ContinueNodes(const Blocks& all, const std::vector<Blocks>& own,
                   size_t table, std::vector<NodePositions>* nodes) {
  const std::vector<bool> needed = FindRequiredNodes(all);
  const std::vector<bool> here = FindRequiredNodes(own[table]);
  if (here == needed) return;
  const auto basis = [&](int k) {
    return Eigen::Vector3d(1, k % (all.columns + 1), k / (all.columns + 1));
  };
  std::vector<bool> is_done = here;
  for (size_t apart = 1; apart < own.size(); ++apart) {
    for (const size_t other : {table - apart, table + apart}) {
      if (other >= own.size()) continue;
      const std::vector<bool> there = FindRequiredNodes(own[other]);
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

// Returns the blocks in which any table has a source.
Blocks MergeBlocks(const std::vector<Blocks>& own) {
  Blocks all = own.front();
  for (const Blocks& blocks : own)
    for (size_t k = 0; k < all.used.size(); ++k)
      all.used[k] = all.used[k] || blocks.used[k];
  return all;
}

// Excludes blocks with a vertex so far outside the format's range that clamping
// causes an error. Returns their number.
int ExcludeOutOfRangeBlocks(const NodePositions& nodes, double max_error_px,
                            Blocks* blocks) {
  const double reach_px = RG_VERTEX_LIMIT_Q12 / kQ12 + max_error_px / 2;
  int num_left_out = 0;
  for (int j = 0; j < blocks->rows; ++j)
    for (int i = 0; i < blocks->columns; ++i) {
      bool is_in_range = true;
      for (int corner = 0; corner < 4; ++corner)
        is_in_range &=
            nodes.row(blocks->VertexIndex(i + corner % 2, j + corner / 2))
                .cwiseAbs()
                .maxCoeff() <= reach_px;
      if (is_in_range || !blocks->IsUsed(i, j)) continue;
      blocks->used[j * blocks->columns + i] = false;
      ++num_left_out;
    }
  return num_left_out;
}

// Fits tables with a block layout, if the format can represent them. Small
// blocks that it cannot represent are excluded from own and all.
std::optional<std::vector<RemapTable>> FitWithLayout(
    const std::vector<std::unique_ptr<MappedInput>>& inputs,
    double max_error_px, const VirtualView& view,
    std::vector<Blocks>* own_blocks, Blocks* all_blocks) {
  std::vector<Blocks>& own = *own_blocks;
  std::vector<RemapTable> tables(inputs.size());
  std::vector<NodePositions> nodes;
  for (size_t t = 0; t < inputs.size(); ++t) {
    nodes.push_back(FitNodes(inputs[t]->map, inputs[t]->sums, own[t]));
    tables[t].num_out_of_range =
        ExcludeOutOfRangeBlocks(nodes[t], max_error_px, &own[t]);
    if (tables[t].num_out_of_range == 0) continue;
    if (own[t].layout.block_log2 > kMaxExcludedBlockLog2) return std::nullopt;
    nodes[t] = FitNodes(inputs[t]->map, inputs[t]->sums, own[t]);
  }
  *all_blocks = MergeBlocks(own);
  const Blocks& all = *all_blocks;
  for (size_t t = 0; t < inputs.size(); ++t) {
    const MappedInput& input = *inputs[t];
    FillFields(input.input.camera->image_size(), input.map, view, all,
               &tables[t]);
  }
  for (size_t t = 0; t < inputs.size(); ++t) ContinueNodes(all, own, t, &nodes);
  if (!QuantizeVertices(all, nodes, &tables) ||
      !QuantizeSagittas(all, nodes, &tables))
    return std::nullopt;
  return tables;
}

// Evaluates a table in the blocks in which it has sources; returns false if its
// error exceeds the limit.
bool MeasureTable(const MappedInput& input, const Blocks& own,
                  double max_error_px, double limit_px, int num_threads,
                  RemapTable* table) {
  RemapTable measured = *table;
  FillFields(input.input.camera->image_size(), input.map, table->view, own,
             &measured);
  const std::optional<double> worst =
      ComputeMaxRemapError(*input.input.camera, input.input.output, input.map,
                           own, measured, limit_px, num_threads);
  if (!worst) return false;
  table->max_error_px = *worst;
  if (*worst > max_error_px) return false;
  table->max_chroma_error_px =
      ComputeMaxChromaError(input.map, measured, num_threads);
  table->section.bound_upx =
      static_cast<uint32_t>(std::min(max_error_px * 1e6, 4e9));
  table->section.max_error_upx =
      static_cast<uint32_t>(std::ceil(table->max_error_px * 1e6));
  return true;
}

// Excludes the blocks of the smallest layout in which a table of own exceeds
// the limit, in all tables.
void ExcludeInaccurateBlocks(
    const std::vector<std::unique_ptr<MappedInput>>& inputs,
    const std::vector<RemapTable>& tables, double max_error_px, int num_threads,
    std::vector<Blocks>* own) {
  std::vector<bool> is_inaccurate(own->front().used.size(), false);
  for (size_t t = 0; t < inputs.size(); ++t) {
    RemapTable measured = tables[t];
    const MappedInput& input = *inputs[t];
    FillFields(input.input.camera->image_size(), input.map, measured.view,
               (*own)[t], &measured);
    const std::vector<bool> beyond =
        FindBlocksAboveError(*input.input.camera, input.input.output, input.map,
                             (*own)[t], measured, max_error_px, num_threads);
    for (size_t k = 0; k < beyond.size(); ++k)
      is_inaccurate[k] = is_inaccurate[k] || beyond[k];
  }
  for (Blocks& blocks : *own)
    for (size_t k = 0; k < is_inaccurate.size(); ++k)
      if (is_inaccurate[k]) blocks.used[k] = false;
}

// Returns tables of the smallest blocks, excluding the few that exceed the
// limit, for example where the distortion almost folds, or at the image's edge;
// nullopt if there are many of them. Each table is fitted again without them,
// since they affect their neighbours.
std::optional<std::vector<RemapTable>> FitExcludingInaccurateBlocks(
    const std::vector<std::unique_ptr<MappedInput>>& inputs,
    double max_error_px, const VirtualView& view, int num_threads,
    const std::function<void()>& go_on, std::vector<Blocks> own,
    std::vector<RemapTable> tables) {
  constexpr int kRounds = 6;
  constexpr double kMaxFraction = 0.02;
  const auto count = [&own] {
    const Blocks all = MergeBlocks(own);
    return std::count(all.used.begin(), all.used.end(), true);
  };
  const auto num_before = count();
  for (int round = 0; round < kRounds; ++round) {
    ExcludeInaccurateBlocks(inputs, tables, max_error_px, num_threads, &own);
    const auto num_inaccurate_blocks = num_before - count();
    if (num_inaccurate_blocks == 0 ||
        static_cast<double>(num_inaccurate_blocks) >
            kMaxFraction * static_cast<double>(num_before))
      return std::nullopt;
    const std::vector<RemapTable> before = tables;
    Blocks all;
    auto fitted = FitWithLayout(inputs, max_error_px, view, &own, &all);
    if (!fitted) return std::nullopt;
    tables = *std::move(fitted);
    bool are_good = true;
    for (size_t t = 0; t < inputs.size(); ++t) {
      go_on();
      tables[t].num_out_of_range += before[t].num_out_of_range;
      tables[t].num_inaccurate_blocks = static_cast<int>(num_inaccurate_blocks);
      are_good &= MeasureTable(*inputs[t], own[t], max_error_px, INFINITY,
                               num_threads, &tables[t]);
    }
    if (are_good) return tables;
  }
  return std::nullopt;
}

// Returns tables that differ only in residuals, bends and errors; view is
// stored as their view.
std::vector<RemapTable> FitTables(const std::vector<TableInput>& asked,
                                  const VirtualView& view, double max_error_px,
                                  int num_threads,
                                  const std::function<void()>& go_on,
                                  InaccurateBlocks rough) {
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
    if (has_hidden && layout.block_log2 > kMaxExcludedBlockLog2) continue;
    const bool is_last = &layout == std::end(kLayouts) - 1;
    if (!is_last &&
        std::any_of(inputs.begin(), inputs.end(), [&](const auto& input) {
          return ComputeMinRemapError(input->map, layout.MinSizeLog2()) >
                 max_error_px;
        }))
      continue;
    std::vector<Blocks> own;
    for (const auto& input : inputs)
      own.push_back(SplitIntoBlocks(input->map, layout));
    Blocks all = MergeBlocks(own);
    if (std::count(all.used.begin(), all.used.end(), true) == 0)
      throw Error(ExitCode::kUsage,
                  "the output view does not overlap the calibrated area; "
                  "rotate it, or increase the field of view");
    std::optional<std::vector<RemapTable>> tables =
        FitWithLayout(inputs, max_error_px, view, &own, &all);
    go_on();
    if (!tables) continue;
    bool are_good = true;
    for (size_t t = 0; t < inputs.size() && (are_good || is_last); ++t) {
      are_good &= MeasureTable(*inputs[t], own[t], max_error_px,
                               is_last ? INFINITY : max_error_px, num_threads,
                               &(*tables)[t]);
      worst_px = std::max(worst_px, (*tables)[t].max_error_px);
    }
    if (are_good) return *std::move(tables);
    if (!is_last || rough == InaccurateBlocks::kReject) continue;
    auto without =
        FitExcludingInaccurateBlocks(inputs, max_error_px, view, num_threads,
                                     go_on, own, *std::move(tables));
    if (without) return *std::move(without);
  }
  // Larger errors make an image unusable.
  constexpr double kMaxUsefulErrorPx = 1;
  throw Error(
      ExitCode::kQualityTooLow,
      fmt::format("the remap error is {:.2g} px with the smallest blocks; {}",
                  worst_px,
                  worst_px <= kMaxUsefulErrorPx
                      ? "increase --max-error-px, or reduce the field of view"
                      : "reduce the field of view, or calibrate again if the "
                        "camera is inaccurate there"));
}

}  // namespace

std::vector<RemapTable> FitRemapTables(
    const std::vector<const CameraModel*>& cameras, const VirtualView& view,
    double max_error_px, int num_threads, const std::function<void()>& go_on,
    const PixelFilter& asked, InaccurateBlocks rough) {
  std::vector<TableInput> inputs;
  for (const CameraModel* camera : cameras) {
    const PixelFilter shows = SelectCameraPixels(*camera, asked);
    inputs.push_back(
        {camera, MakeViewOutput(view), [shows](SourceMap* map) {
           if (shows)
             MarkHiddenCells([&](int x, int y) { return shows(map->At(x, y)); },
                             map);
         }});
  }
  return FitTables(inputs, view, max_error_px, num_threads, go_on, rough);
}

std::vector<RemapTable> FitDistortionTables(
    const std::vector<const CameraModel*>& cameras, const VirtualView& view,
    double max_error_px, int num_threads, const std::function<void()>& go_on,
    const PixelFilter& asked, InaccurateBlocks rough) {
  const std::unique_ptr<CameraModel> turned = MakeRotatedViewCamera(view);
  std::vector<TableInput> inputs;
  for (const CameraModel* camera : cameras) {
    const PixelFilter shows = SelectCameraPixels(*camera, asked);
    inputs.push_back(
        {turned.get(), MakeCameraOutput(*camera), [shows](SourceMap* map) {
           if (shows)
             MarkHiddenCells([&](int x, int y) { return shows({x, y}); }, map);
         }});
  }
  std::vector<RemapTable> tables =
      FitTables(inputs, view, max_error_px, num_threads, go_on, rough);
  for (RemapTable& table : tables) {
    table.section.has_view = 1;
    table.section.direction = RG_DISTORT;
  }
  return tables;
}

}  // namespace raygrid
