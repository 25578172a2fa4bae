#include "packing/remap_fitting.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

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

ExactMap ComputeExactMap(const CameraModel& camera,
                         const VirtualCamera& virtual_camera, int num_threads) {
  ExactMap map;
  map.width = virtual_camera.size.width;
  map.height = virtual_camera.size.height;
  map.sources.assign(static_cast<size_t>(map.width) * map.height,
                     Eigen::Vector2d(NAN, NAN));
  ParallelFor(map.height, num_threads, [&](int y) {
    const Eigen::Vector2d* start = nullptr;
    for (int x = 0; x < map.width; ++x) {
      Eigen::Vector2d& source =
          map.sources[static_cast<size_t>(y) * map.width + x];
      const auto pixel = camera.Project(
          virtual_camera.Direction(Eigen::Vector2d(x, y)), start, kFitMarginPx);
      start = pixel ? &source : nullptr;
      if (pixel) source = *pixel;
    }
  });
  return map;
}

// The blocks of a table, and which of them have a source.
struct Blocks {
  int size_log2 = 0, columns = 0, rows = 0;
  std::vector<bool> used;

  int size() const { return 1 << size_log2; }
  int num_vertices() const { return (columns + 1) * (rows + 1); }
  int VertexIndex(int i, int j) const { return j * (columns + 1) + i; }
};

Blocks CutBlocks(const ExactMap& map, const Area& rectangle, int size_log2) {
  Blocks blocks;
  blocks.size_log2 = size_log2;
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

// Least-squares vertices for bilinear interpolation within the blocks, in
// pixels; where no pixel determines one, second differences vanish.
std::vector<Eigen::Vector2d> FitVertices(const ExactMap& map,
                                         const Blocks& blocks) {
  const int n = blocks.num_vertices();
  std::vector<Eigen::Triplet<double>> triplets;
  Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(n, 2);
  for (int j = 0; j < blocks.rows; ++j) {
    for (int i = 0; i < blocks.columns; ++i) {
      const int vertices[4] = {
          blocks.VertexIndex(i, j), blocks.VertexIndex(i + 1, j),
          blocks.VertexIndex(i, j + 1), blocks.VertexIndex(i + 1, j + 1)};
      Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
      const int x0 = i << blocks.size_log2, y0 = j << blocks.size_log2;
      for (int y = y0; y < std::min(y0 + blocks.size(), map.height); ++y) {
        for (int x = x0; x < std::min(x0 + blocks.size(), map.width); ++x) {
          if (!map.IsValid(x, y)) continue;
          const double u = static_cast<double>(x - x0) / blocks.size();
          const double v = static_cast<double>(y - y0) / blocks.size();
          const Eigen::Vector4d weights((1 - u) * (1 - v), u * (1 - v),
                                        (1 - u) * v, u * v);
          normal += weights * weights.transpose();
          for (int k = 0; k < 4; ++k)
            right.row(vertices[k]) += weights[k] * map.at(x, y).transpose();
        }
      }
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b)
          triplets.emplace_back(vertices[a], vertices[b], normal(a, b));
    }
  }
  const auto smooth = [&](int a, int b, int c) {
    const int index[3] = {a, b, c};
    const double row[3] = {1, -2, 1};
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < 3; ++l)
        triplets.emplace_back(index[k], index[l], 1e-4 * row[k] * row[l]);
  };
  for (int j = 0; j <= blocks.rows; ++j) {
    for (int i = 0; i <= blocks.columns; ++i) {
      const int k = blocks.VertexIndex(i, j);
      if (i > 0 && i < blocks.columns) smooth(k - 1, k, k + 1);
      if (j > 0 && j < blocks.rows)
        smooth(blocks.VertexIndex(i, j - 1), k, blocks.VertexIndex(i, j + 1));
    }
  }
  for (int k = 0; k < n; ++k) triplets.emplace_back(k, k, 1e-9);

  Eigen::SparseMatrix<double> normal(n, n);
  normal.setFromTriplets(triplets.begin(), triplets.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(normal);
  const Eigen::MatrixX2d solution = solver.solve(right);
  std::vector<Eigen::Vector2d> vertices(n);
  for (int k = 0; k < n; ++k) vertices[k] = solution.row(k).transpose();
  return vertices;
}

// Where second derivatives are constant, the error of interpolation is a
// parabola of some height in each direction. Least squares put its ends, the
// vertices, 2/3 of the height to one side of the exact position; half of the
// height, 3/4 of that, makes the largest error least. Vertices beyond the
// image follow the last one in it.
std::vector<Eigen::Vector2d> BalanceVertices(
    const ExactMap& map, const Blocks& blocks,
    const std::vector<Eigen::Vector2d>& fitted) {
  std::vector<Eigen::Vector2d> balanced = fitted;
  for (int j = 0; j <= blocks.rows; ++j) {
    for (int i = 0; i <= blocks.columns; ++i) {
      const int in_i = std::min(i, blocks.columns - 1);
      const int in_j = std::min(j, blocks.rows - 1);
      const int x = in_i << blocks.size_log2, y = in_j << blocks.size_log2;
      if (!map.IsValid(x, y)) continue;
      balanced[blocks.VertexIndex(i, j)] +=
          0.25 * (map.at(x, y) - fitted[blocks.VertexIndex(in_i, in_j)]);
    }
  }
  return balanced;
}

// The affine map closest to the vertices of used blocks: origin, column step,
// row step.
Eigen::Matrix<double, 3, 2> FitAffine(const Blocks& blocks,
                                      const std::vector<Eigen::Vector2d>& v) {
  Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  for (int j = 0; j < blocks.rows; ++j) {
    for (int i = 0; i < blocks.columns; ++i) {
      if (!blocks.used[j * blocks.columns + i]) continue;
      for (int corner = 0; corner < 4; ++corner) {
        const int ci = i + corner % 2, cj = j + corner / 2;
        const Eigen::Vector3d basis(1, ci, cj);
        normal += basis * basis.transpose();
        right += basis * v[blocks.VertexIndex(ci, cj)].transpose();
      }
    }
  }
  return normal.ldlt().solve(right);
}

// Vertices that only empty blocks have may lie anywhere; they are brought near.
std::vector<bool> NeededVertices(const Blocks& blocks) {
  std::vector<bool> needed(blocks.num_vertices(), false);
  for (int j = 0; j < blocks.rows; ++j)
    for (int i = 0; i < blocks.columns; ++i)
      if (blocks.used[j * blocks.columns + i])
        for (int corner = 0; corner < 4; ++corner)
          needed[blocks.VertexIndex(i + corner % 2, j + corner / 2)] = true;
  return needed;
}

// q12 rounding of affine part and residuals with the smallest shift that lets
// all residuals fit; false if none does.
bool Quantize(const Blocks& blocks,
              const std::vector<Eigen::Vector2d>& vertices, RemapTable* table) {
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

  const std::vector<bool> needed = NeededVertices(blocks);
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
            needed[k] ? vertices[k][c] * kQ12 : std::clamp(base[c], 0.0, 1.0);
        residuals_q12.push_back(std::clamp(target, -kLimit, kLimit) - base[c]);
        if (needed[k])
          largest = std::max(largest, std::abs(residuals_q12.back()));
      }
    }
  }
  int shift = 0;
  while (largest / (1 << shift) > 32766) ++shift;
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
  std::vector<double> worst(map.height, 0);
  ParallelFor(map.height, num_threads, [&](int y) {
    const int j = y >> blocks.size_log2;
    rg_block_walk walk;
    rg_start_walk(section, j, &walk);
    for (int i = 0; i < blocks.columns; ++i) {
      rg_block block;
      rg_block_row row;
      rg_next_block(&walk, &block);
      if (!blocks.used[j * blocks.columns + i]) continue;
      rg_find_block_row(&block, y & (blocks.size() - 1), &row);
      const int x0 = i << blocks.size_log2;
      for (int x = x0; x < std::min(x0 + blocks.size(), map.width); ++x) {
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
  for (int size_log2 = 5; size_log2 >= 3; --size_log2) {
    const Blocks blocks = CutBlocks(map, rectangle, size_log2);
    if (std::count(blocks.used.begin(), blocks.used.end(), true) == 0)
      throw Error(ExitCode::kUsage,
                  "the virtual camera sees nothing of the calibrated area; "
                  "check --hfov");
    FillFields(camera, virtual_camera, blocks, &table);
    const std::vector<Eigen::Vector2d> vertices =
        BalanceVertices(map, blocks, FitVertices(map, blocks));
    if (!Quantize(blocks, vertices, &table)) continue;
    table.max_error_px =
        MeasureError(map, rectangle, blocks, table, num_threads);
    // Half the size has a quarter of the error: a hopeless one is skipped.
    if (size_log2 == 5 && table.max_error_px > 8 * max_error_px) --size_log2;
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
