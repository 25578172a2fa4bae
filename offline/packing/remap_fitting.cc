#include "packing/remap_fitting.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "remap_table.h"

namespace raygrid {
namespace {

constexpr double kQ12 = 4096;

// The exact source position of every output pixel; NaN where there is none.
struct ExactMap {
  int width = 0, height = 0;
  std::vector<Eigen::Vector2d> sources;

  const Eigen::Vector2d& at(int x, int y) const {
    return sources[static_cast<size_t>(y) * width + x];
  }
  bool IsValid(int x, int y) const { return at(x, y).x() == at(x, y).x(); }
};

// Within the calibrated area and the pixels' centres.
Area SourceRectangle(const CameraModel& camera) {
  const Area& area = camera.area();
  const Area image = WholeImage(camera.image_size());
  return {std::max(area.x0, image.x0), std::max(area.y0, image.y0),
          std::min(area.x1, image.x1), std::min(area.y1, image.y1)};
}

// A little beyond the rectangle, so that the fit is not one-sided at its edge.
constexpr double kFitMarginPx = 1.5;

// Output pixels every few, of which some have a source: where none around a
// pixel has, it has none either, which projection would be long to find out.
class SeenParts {
 public:
  SeenParts(const CameraModel& camera, const VirtualCamera& virtual_camera,
            int num_threads)
      : columns_(virtual_camera.size.width / kStep + 2),
        rows_(virtual_camera.size.height / kStep + 2),
        is_seen_(static_cast<size_t>(columns_) * rows_) {
    ParallelFor(rows_, num_threads, [&](int j) {
      std::optional<Eigen::Vector2d> last;
      for (int i = 0; i < columns_; ++i) {
        last = camera.Project(
            virtual_camera.Direction(Eigen::Vector2d(i * kStep, j * kStep)),
            last ? &*last : nullptr, kFitMarginPx);
        is_seen_[static_cast<size_t>(j) * columns_ + i] = last.has_value();
      }
    });
  }

  // Whether any of the sixteen around the pixel has a source.
  bool Has(int x, int y) const {
    const int i = x / kStep, j = y / kStep;
    for (int row = std::max(j - 1, 0); row <= std::min(j + 2, rows_ - 1); ++row)
      for (int column = std::max(i - 1, 0);
           column <= std::min(i + 2, columns_ - 1); ++column)
        if (is_seen_[static_cast<size_t>(row) * columns_ + column]) return true;
    return false;
  }

 private:
  static constexpr int kStep = 4;
  int columns_, rows_;
  std::vector<uint8_t> is_seen_;
};

ExactMap ComputeExactMap(const CameraModel& camera,
                         const VirtualCamera& virtual_camera, int num_threads) {
  ExactMap map;
  map.width = virtual_camera.size.width;
  map.height = virtual_camera.size.height;
  map.sources.assign(static_cast<size_t>(map.width) * map.height,
                     Eigen::Vector2d(NAN, NAN));
  const SeenParts seen(camera, virtual_camera, num_threads);
  ParallelFor(map.height, num_threads, [&](int y) {
    Eigen::Vector2d* const row =
        &map.sources[static_cast<size_t>(y) * map.width];
    for (int x = 0; x < map.width; ++x) {
      if (!seen.Has(x, y)) continue;
      // As far on as from the pixel before the last to the last.
      Eigen::Vector2d start(NAN, NAN);
      if (x >= 1) start = row[x - 1];
      if (x >= 2 && map.IsValid(x - 2, y)) start += row[x - 1] - row[x - 2];
      const auto pixel = camera.Project(
          virtual_camera.Direction(Eigen::Vector2d(x, y)),
          x >= 1 && map.IsValid(x - 1, y) ? &start : nullptr, kFitMarginPx);
      if (pixel) row[x] = *pixel;
    }
  });
  return map;
}

// Sizes of blocks and, where their edges are bent, of the parts that the
// runtime cuts them into.
struct BlockLayout {
  int block_log2;
  int part_log2;  // 0: not bent

  int SmallestLog2() const { return part_log2 != 0 ? part_log2 : block_log2; }
};

// Large parts, which remap faster, before small ones; then few bytes.
constexpr BlockLayout kLayouts[] = {{6, 5}, {5, 0}, {6, 4}, {5, 4}, {4, 0},
                                    {6, 3}, {5, 3}, {4, 3}, {3, 0}};

// The blocks of a table, and which of them have a source. What is fitted are
// nodes: the vertices, and behind them as many bends of the edges to the left
// of each vertex, and of those above it. A bend is how far an edge's middle
// lies from the straight line.
struct Blocks {
  int size_log2 = 0, part_log2 = 0, columns = 0, rows = 0;
  std::vector<bool> used;

  bool IsBent() const { return part_log2 != 0; }
  int size() const { return 1 << size_log2; }
  int num_vertices() const { return (columns + 1) * (rows + 1); }
  int num_nodes() const { return num_vertices() * (IsBent() ? 3 : 1); }
  int VertexIndex(int i, int j) const { return j * (columns + 1) + i; }
  int LeftBend(int i, int j) const {
    return num_vertices() + VertexIndex(i, j);
  }
  int UpperBend(int i, int j) const {
    return 2 * num_vertices() + VertexIndex(i, j);
  }
};

Blocks CutBlocks(const ExactMap& map, const Area& rectangle,
                 const BlockLayout& layout) {
  const int size_log2 = layout.block_log2;
  Blocks blocks;
  blocks.size_log2 = size_log2;
  blocks.part_log2 = layout.part_log2;
  blocks.columns = ((map.width - 1) >> size_log2) + 1;
  blocks.rows = ((map.height - 1) >> size_log2) + 1;
  blocks.used.assign(blocks.columns * blocks.rows, false);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      if (map.IsValid(x, y) && rectangle.Contains(map.at(x, y)))
        blocks.used[(y >> size_log2) * blocks.columns + (x >> size_log2)] =
            true;
  return blocks;
}

// What the nodes of a block are multiplied with to get the position of one of
// its pixels. Bends count most in the middle of their edge, not at all at its
// ends and on the opposite edge; between the corners of the parts all is
// linear.
class BlockBasis {
 public:
  static constexpr int kMaxSize = 8;
  using Values = Eigen::Matrix<double, kMaxSize, 1>;

  explicit BlockBasis(const Blocks& blocks)
      : blocks_(blocks), size_(blocks.IsBent() ? kMaxSize : 4) {
    const int n = blocks.size(), part = 1 << blocks.part_log2;
    const auto curve = [n](int x) { return 4.0 * x * (n - x) / (n * n); };
    for (int x = 0; x < n; ++x) {
      const int first = x / part * part;
      curve_.push_back(curve(first) + (curve(first + part) - curve(first)) *
                                          (x - first) / part);
    }
  }

  int size() const { return size_; }

  std::array<int, kMaxSize> Nodes(int i, int j) const {
    return {blocks_.VertexIndex(i, j),     blocks_.VertexIndex(i + 1, j),
            blocks_.VertexIndex(i, j + 1), blocks_.VertexIndex(i + 1, j + 1),
            blocks_.LeftBend(i + 1, j),    blocks_.LeftBend(i + 1, j + 1),
            blocks_.UpperBend(i, j + 1),   blocks_.UpperBend(i + 1, j + 1)};
  }

  // Of pixel (x, y) of the block; the last four only count where it is bent.
  Values At(int x, int y) const {
    const double u = static_cast<double>(x) / blocks_.size();
    const double v = static_cast<double>(y) / blocks_.size();
    const double across = curve_[x], down = curve_[y];
    Values values;
    values << (1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v,
        across * (1 - v), across * v, down * (1 - u), down * u;
    return values;
  }

 private:
  const Blocks& blocks_;
  int size_;
  std::vector<double> curve_;
};

// Least-squares nodes, in pixels; where no pixel determines one, second
// differences of its kind vanish.
Eigen::MatrixX2d FitNodes(const ExactMap& map, const Blocks& blocks) {
  using Normal =
      Eigen::Matrix<double, BlockBasis::kMaxSize, BlockBasis::kMaxSize>;
  const int n = blocks.num_nodes();
  const BlockBasis basis(blocks);
  std::vector<BlockBasis::Values> values;  // of a block's pixels
  Normal whole = Normal::Zero();           // of a block with all its pixels
  for (int y = 0; y < blocks.size(); ++y) {
    for (int x = 0; x < blocks.size(); ++x) {
      values.push_back(basis.At(x, y));
      whole += values.back() * values.back().transpose();
    }
  }
  std::vector<Eigen::Triplet<double>> triplets;
  Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(n, 2);
  std::vector<int> known;  // the block's pixels that have a source
  for (int j = 0; j < blocks.rows; ++j) {
    for (int i = 0; i < blocks.columns; ++i) {
      const auto nodes = basis.Nodes(i, j);
      Eigen::Matrix<double, BlockBasis::kMaxSize, 2> sums;
      sums.setZero();
      known.clear();
      const int x0 = i << blocks.size_log2, y0 = j << blocks.size_log2;
      for (int y = y0; y < std::min(y0 + blocks.size(), map.height); ++y) {
        for (int x = x0; x < std::min(x0 + blocks.size(), map.width); ++x) {
          if (!map.IsValid(x, y)) continue;
          known.push_back((y - y0) * blocks.size() + x - x0);
          sums += values[known.back()] * map.at(x, y).transpose();
        }
      }
      Normal part = Normal::Zero();
      const bool is_whole = known.size() == values.size();
      if (!is_whole)
        for (const int k : known) part += values[k] * values[k].transpose();
      const Normal& normal = is_whole ? whole : part;
      for (int a = 0; a < basis.size(); ++a) {
        right.row(nodes[a]) += sums.row(a);
        for (int b = 0; b < basis.size(); ++b)
          triplets.emplace_back(nodes[a], nodes[b], normal(a, b));
      }
    }
  }
  const auto smooth = [&](int a, int b, int c) {
    const int index[3] = {a, b, c};
    const double row[3] = {1, -2, 1};
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < 3; ++l)
        triplets.emplace_back(index[k], index[l], 1e-4 * row[k] * row[l]);
  };
  const int down = blocks.columns + 1;
  for (int first = 0; first < n; first += blocks.num_vertices()) {
    for (int j = 0; j <= blocks.rows; ++j) {
      for (int i = 0; i <= blocks.columns; ++i) {
        const int k = first + blocks.VertexIndex(i, j);
        if (i > 0 && i < blocks.columns) smooth(k - 1, k, k + 1);
        if (j > 0 && j < blocks.rows) smooth(k - down, k, k + down);
      }
    }
  }
  for (int k = 0; k < n; ++k) triplets.emplace_back(k, k, 1e-9);

  Eigen::SparseMatrix<double> normal(n, n);
  normal.setFromTriplets(triplets.begin(), triplets.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(normal);
  return solver.solve(right);
}

// Where second derivatives are constant, the error of interpolation is a
// parabola of some height in each direction. Least squares put its ends, the
// vertices, 2/3 of the height to one side of the exact position; half of the
// height, 3/4 of that, makes the largest error least. The same holds for the
// parts between an edge's ends and its middle. Vertices beyond the image follow
// the last one in it.
Eigen::MatrixX2d BalanceNodes(const ExactMap& map, const Blocks& blocks,
                              const Eigen::MatrixX2d& fitted) {
  Eigen::MatrixX2d moves = Eigen::MatrixX2d::Zero(fitted.rows(), 2);
  // What is lacking at an output pixel; nothing where that is not known.
  const auto lack = [&](int x, int y, const Eigen::RowVector2d& position) {
    if (x >= map.width || y >= map.height || !map.IsValid(x, y))
      return Eigen::RowVector2d(0, 0);
    return Eigen::RowVector2d(0.25 * (map.at(x, y).transpose() - position));
  };
  for (int j = 0; j <= blocks.rows; ++j) {
    for (int i = 0; i <= blocks.columns; ++i) {
      const int in_i = std::min(i, blocks.columns - 1);
      const int in_j = std::min(j, blocks.rows - 1);
      moves.row(blocks.VertexIndex(i, j)) =
          lack(in_i << blocks.size_log2, in_j << blocks.size_log2,
               fitted.row(blocks.VertexIndex(in_i, in_j)));
    }
  }
  // The edge from vertex a to b, whose middle is output pixel (x, y).
  const auto balance = [&](int a, int b, int bend, int x, int y) {
    const Eigen::RowVector2d line = (fitted.row(a) + fitted.row(b)) / 2;
    const Eigen::RowVector2d moved = (moves.row(a) + moves.row(b)) / 2;
    moves.row(bend) = lack(x, y, line + fitted.row(bend)) - moved;
  };
  for (int j = 0; j <= blocks.rows && blocks.IsBent(); ++j) {
    for (int i = 0; i <= blocks.columns; ++i) {
      const int x = i << blocks.size_log2, y = j << blocks.size_log2;
      const int half = blocks.size() / 2, k = blocks.VertexIndex(i, j);
      if (i > 0) balance(k - 1, k, blocks.LeftBend(i, j), x - half, y);
      if (j > 0)
        balance(blocks.VertexIndex(i, j - 1), k, blocks.UpperBend(i, j), x,
                y - half);
    }
  }
  return fitted + moves;
}

// The affine map closest to the vertices of used blocks: origin, column step,
// row step.
Eigen::Matrix<double, 3, 2> FitAffine(const Blocks& blocks,
                                      const Eigen::MatrixX2d& nodes) {
  Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  for (int j = 0; j < blocks.rows; ++j) {
    for (int i = 0; i < blocks.columns; ++i) {
      if (!blocks.used[j * blocks.columns + i]) continue;
      for (int corner = 0; corner < 4; ++corner) {
        const int ci = i + corner % 2, cj = j + corner / 2;
        const Eigen::Vector3d basis(1, ci, cj);
        normal += basis * basis.transpose();
        right += basis * nodes.row(blocks.VertexIndex(ci, cj));
      }
    }
  }
  return normal.ldlt().solve(right);
}

// Nodes that only empty blocks have may lie anywhere; they are brought near.
std::vector<bool> NeededNodes(const Blocks& blocks) {
  const BlockBasis basis(blocks);
  std::vector<bool> needed(blocks.num_nodes(), false);
  for (int j = 0; j < blocks.rows; ++j)
    for (int i = 0; i < blocks.columns; ++i)
      if (blocks.used[j * blocks.columns + i])
        for (int k = 0; k < basis.size(); ++k)
          needed[basis.Nodes(i, j)[k]] = true;
  return needed;
}

// The smallest shift that lets all values fit into a range.
int FittingShift(double largest, double limit) {
  int shift = 0;
  while (largest / (1 << shift) > limit) ++shift;
  return shift;
}

// The bends in 8 bits, as 4 / N of how far an edge of N parts bends, with the
// smallest shift that lets all fit; false if none does.
bool QuantizeBends(const Blocks& blocks, const Eigen::MatrixX2d& nodes,
                   RemapTable* table) {
  table->bends.clear();
  table->section.bend_shift = 0;
  if (!blocks.IsBent()) return true;
  const std::vector<bool> needed = NeededNodes(blocks);
  const double unit = kQ12 * std::ldexp(4, blocks.part_log2 - blocks.size_log2);
  const auto value = [&](int node, int c) {
    return needed[node] ? unit * nodes(node, c) : 0.0;
  };
  double largest = 0;
  for (int k = blocks.num_vertices(); k < blocks.num_nodes(); ++k)
    for (int c = 0; c < 2; ++c)
      largest = std::max(largest, std::abs(value(k, c)));
  const int shift = FittingShift(largest, 127);
  if (shift > static_cast<int>(RG_MAX_BEND_SHIFT)) return false;
  table->section.bend_shift = static_cast<uint8_t>(shift);
  for (int j = 0; j <= blocks.rows; ++j)
    for (int i = 0; i <= blocks.columns; ++i)
      for (const int bend : {blocks.LeftBend(i, j), blocks.UpperBend(i, j)})
        for (int c = 0; c < 2; ++c)
          table->bends.push_back(
              static_cast<int8_t>(std::lround(value(bend, c) / (1 << shift))));
  return true;
}

// q12 rounding of affine part and residuals with the smallest shift that lets
// all residuals fit; false if none does.
bool QuantizeVertices(const Blocks& blocks, const Eigen::MatrixX2d& vertices,
                      RemapTable* table) {
  const Eigen::Matrix<double, 3, 2> affine = FitAffine(blocks, vertices);
  const auto q12 = [](double value) {
    return static_cast<int32_t>(std::lround(value * kQ12));
  };
  rg_remap_section& s = table->section;
  s.origin_x_q12 = q12(affine(0, 0));
  s.origin_y_q12 = q12(affine(0, 1));
  s.column_step_x_q12 = q12(affine(1, 0));
  s.column_step_y_q12 = q12(affine(1, 1));
  s.row_step_x_q12 = q12(affine(2, 0));
  s.row_step_y_q12 = q12(affine(2, 1));

  const std::vector<bool> needed = NeededNodes(blocks);
  std::vector<double> residuals_q12;
  double largest = 0;
  for (int j = 0; j <= blocks.rows; ++j) {
    for (int i = 0; i <= blocks.columns; ++i) {
      const int k = blocks.VertexIndex(i, j);
      const double base[2] = {static_cast<double>(s.origin_x_q12) +
                                  static_cast<double>(i) * s.column_step_x_q12 +
                                  static_cast<double>(j) * s.row_step_x_q12,
                              static_cast<double>(s.origin_y_q12) +
                                  static_cast<double>(i) * s.column_step_y_q12 +
                                  static_cast<double>(j) * s.row_step_y_q12};
      for (int c = 0; c < 2; ++c) {
        constexpr double kLimit = RG_VERTEX_LIMIT_Q12 - 4096;
        const double target =
            needed[k] ? vertices(k, c) * kQ12 : std::clamp(base[c], 0.0, 1.0);
        residuals_q12.push_back(std::clamp(target, -kLimit, kLimit) - base[c]);
        if (needed[k])
          largest = std::max(largest, std::abs(residuals_q12.back()));
      }
    }
  }
  const int shift = FittingShift(largest, 32766);
  if (shift > static_cast<int>(RG_MAX_RESIDUAL_SHIFT)) return false;
  s.residual_shift = static_cast<uint8_t>(shift);
  table->residuals.clear();
  for (const double residual : residuals_q12)
    table->residuals.push_back(static_cast<int16_t>(
        std::clamp<long>(std::lround(residual / (1 << shift)), -32768, 32767)));
  return true;
}

void FillFields(const CameraModel& camera, const VirtualCamera& virtual_camera,
                const Blocks& blocks, RemapTable* table) {
  rg_remap_section& s = table->section;
  s.width = static_cast<uint16_t>(virtual_camera.size.width);
  s.height = static_cast<uint16_t>(virtual_camera.size.height);
  s.columns = static_cast<uint16_t>(blocks.columns + 1);
  s.rows = static_cast<uint16_t>(blocks.rows + 1);
  s.block_log2 = static_cast<uint8_t>(blocks.size_log2);
  s.part_log2 = static_cast<uint8_t>(blocks.part_log2);
  const Area rectangle = SourceRectangle(camera);
  s.min_x_q12 = static_cast<int32_t>(std::ceil(rectangle.x0 * kQ12));
  s.min_y_q12 = static_cast<int32_t>(std::ceil(rectangle.y0 * kQ12));
  s.max_x_q12 = static_cast<int32_t>(std::floor(rectangle.x1 * kQ12));
  s.max_y_q12 = static_cast<int32_t>(std::floor(rectangle.y1 * kQ12));
  s.fx_q16 = s.fy_q16 =
      static_cast<uint32_t>(std::lround(virtual_camera.focal_px * 65536));
  s.cx_q16 =
      static_cast<int32_t>(std::lround(virtual_camera.center.x() * 65536));
  s.cy_q16 =
      static_cast<int32_t>(std::lround(virtual_camera.center.y() * 65536));
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

// What is wrong about an output pixel: the distance of its position from the
// exact one; for a pixel without exact position, how far inside the rectangle
// the table puts it.
double PixelError(const ExactMap& map, const Area& rectangle, int x, int y,
                  const Eigen::Vector2d& position) {
  const bool taken = rectangle.Contains(position);
  if (map.IsValid(x, y)) {
    const bool wanted = rectangle.Contains(map.at(x, y));
    return taken || wanted ? (position - map.at(x, y)).norm() : 0;
  }
  if (!taken) return 0;
  const Eigen::Vector2d inside(
      std::min(position.x() - rectangle.x0, rectangle.x1 - position.x()),
      std::min(position.y() - rectangle.y0, rectangle.y1 - position.y()));
  return std::max(1.0, inside.minCoeff());
}

// The worst PixelError, with the integers of the board.
double MeasureError(const ExactMap& map, const Area& rectangle,
                    const Blocks& blocks, const RemapTable& table,
                    int num_threads) {
  const std::vector<uint32_t> words = SectionWords(table);
  const auto* section = reinterpret_cast<const uint8_t*>(words.data());
  const int log2 = blocks.IsBent() ? blocks.part_log2 : blocks.size_log2;
  const int part = 1 << log2;
  std::vector<double> worst(map.height, 0);
  ParallelFor(map.height, num_threads, [&](int y) {
    rg_block_walk walk;
    rg_start_walk(section, log2, log2, y >> log2, &walk);
    for (int x0 = 0; x0 < map.width; x0 += part) {
      rg_block block;
      rg_block_row row;
      rg_next_block(&walk, &block);
      if (!blocks.used[(y >> blocks.size_log2) * blocks.columns +
                       (x0 >> blocks.size_log2)])
        continue;
      rg_find_block_row(&block, y & (part - 1), &row);
      for (int x = x0; x < std::min(x0 + part, map.width); ++x) {
        const rg_position p = rg_row_position(&row, x - x0);
        const Eigen::Vector2d position(p.q12[0] / kQ12, p.q12[1] / kQ12);
        worst[y] =
            std::max(worst[y], PixelError(map, rectangle, x, y, position));
      }
    }
  });
  return *std::max_element(worst.begin(), worst.end());
}

void RequireFormatLimits(const CameraModel& camera,
                         const VirtualCamera& virtual_camera) {
  const int limit = RG_MAX_REMAP_SIZE;
  for (const ImageSize& size : {camera.image_size(), virtual_camera.size})
    if (size.width < 1 || size.height < 1 || size.width > limit ||
        size.height > limit)
      throw Error(ExitCode::kUsage,
                  fmt::format("remap of {} x {} pixels: sizes are 1 to {}",
                              size.width, size.height, limit));
}

}  // namespace

RemapTable FitRemapTable(const CameraModel& camera,
                         const VirtualCamera& virtual_camera,
                         double max_error_px, int num_threads) {
  RequireFormatLimits(camera, virtual_camera);
  num_threads = NumThreads(num_threads);
  const Area rectangle = SourceRectangle(camera);
  const ExactMap map = ComputeExactMap(camera, virtual_camera, num_threads);
  RemapTable table;
  double straight_error_px = 0;  // of straight blocks of 32, once known
  for (const BlockLayout& layout : kLayouts) {
    // Half the size has a quarter of the error: what is hopeless is skipped.
    const double expected_px =
        std::ldexp(straight_error_px, 2 * (layout.SmallestLog2() - 5));
    if (expected_px > 2 * max_error_px && layout.block_log2 > 3) continue;
    const Blocks blocks = CutBlocks(map, rectangle, layout);
    if (std::count(blocks.used.begin(), blocks.used.end(), true) == 0)
      throw Error(ExitCode::kUsage,
                  "the virtual camera sees nothing of the calibrated area; "
                  "check --hfov");
    FillFields(camera, virtual_camera, blocks, &table);
    const Eigen::MatrixX2d nodes =
        BalanceNodes(map, blocks, FitNodes(map, blocks));
    if (!QuantizeVertices(blocks, nodes, &table) ||
        !QuantizeBends(blocks, nodes, &table))
      continue;
    table.max_error_px =
        MeasureError(map, rectangle, blocks, table, num_threads);
    if (layout.block_log2 == 5 && layout.part_log2 == 0)
      straight_error_px = table.max_error_px;
    if (table.max_error_px <= max_error_px) {
      table.section.bound_upx =
          static_cast<uint32_t>(std::min(max_error_px * 1e6, 4e9));
      table.section.max_error_upx =
          static_cast<uint32_t>(std::ceil(table.max_error_px * 1e6));
      return table;
    }
  }
  throw Error(ExitCode::kQuality,
              fmt::format("the remap's geometric error is {:.3f} px with the "
                          "smallest blocks; allow that with --max-error-px, or "
                          "ask for a smaller --hfov",
                          table.max_error_px));
}

}  // namespace raygrid
