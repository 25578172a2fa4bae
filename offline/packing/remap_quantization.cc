#include "packing/remap_quantization.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

constexpr double kVertexUnits = 4096;  // per pixel

// Returns the affine map fitted to the vertices of used blocks: origin, column
// step, row step.
Eigen::Matrix<double, 3, 2> FitAffine(const Blocks& blocks,
                                      const NodePositions& nodes) {
  Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  for (int j = 0; j < blocks.rows; ++j) {
    for (int i = 0; i < blocks.columns; ++i) {
      if (!blocks.IsUsed(i, j)) continue;
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

// Returns the smallest shift with which all values fit into a range.
int FittingShift(double largest, double limit) {
  int shift = 0;
  while (largest / (1 << shift) > limit) ++shift;
  return shift;
}

// Returns a residual in units of 2^shift, by which the vertex stays within the
// limit.
int16_t RoundedResidual(double residual_q12, int64_t base_q12, int shift) {
  constexpr int64_t kLimit = RG_VERTEX_LIMIT_Q12;
  int64_t rounded = std::clamp<int64_t>(
      std::llround(residual_q12 / (1 << shift)), -32768, 32767);
  const int64_t position = base_q12 + rounded * (int64_t{1} << shift);
  if (position >= kLimit) --rounded;
  if (position <= -kLimit) ++rounded;
  return static_cast<int16_t>(rounded);
}

// Returns the position of a vertex according to the section's affine map.
int64_t BaseQ12(const rg_remap_section& s, int column, int row, int axis) {
  return axis == 0 ? s.origin_x_q12 + int64_t{column} * s.column_step_x_q12 +
                         int64_t{row} * s.row_step_x_q12
                   : s.origin_y_q12 + int64_t{column} * s.column_step_y_q12 +
                         int64_t{row} * s.row_step_y_q12;
}

// Fits the affine map of all tables to the vertices of the first one.
void QuantizePlane(const Blocks& blocks,
                   const std::vector<NodePositions>& vertices,
                   std::vector<RemapTable>* tables) {
  const Eigen::Matrix<double, 3, 2> affine = FitAffine(blocks, vertices[0]);
  const auto q12 = [](double value) {
    return static_cast<int32_t>(std::lround(value * kVertexUnits));
  };
  for (RemapTable& table : *tables) {
    rg_remap_section& s = table.section;
    s.origin_x_q12 = q12(affine(0, 0));
    s.origin_y_q12 = q12(affine(0, 1));
    s.column_step_x_q12 = q12(affine(1, 0));
    s.column_step_y_q12 = q12(affine(1, 1));
    s.row_step_x_q12 = q12(affine(2, 0));
    s.row_step_y_q12 = q12(affine(2, 1));
  }
}

// Returns the residuals of vertices from the section's affine map; unused ones
// are clamped. *largest is raised to the maximum of the used ones.
std::vector<double> ResidualsQ12(const Blocks& blocks,
                                 const NodePositions& vertices,
                                 const rg_remap_section& s, double* largest) {
  const std::vector<bool> needed = FindRequiredNodes(blocks);
  std::vector<double> residuals_q12;
  for (int j = 0; j <= blocks.rows; ++j) {
    for (int i = 0; i <= blocks.columns; ++i) {
      const int k = blocks.VertexIndex(i, j);
      const double base[2] = {static_cast<double>(BaseQ12(s, i, j, 0)),
                              static_cast<double>(BaseQ12(s, i, j, 1))};
      for (int c = 0; c < 2; ++c) {
        constexpr double kLimit = RG_VERTEX_LIMIT_Q12 - 1.0;
        const double target = needed[k] ? vertices(k, c) * kVertexUnits
                                        : std::clamp(base[c], 0.0, 1.0);
        residuals_q12.push_back(std::clamp(target, -kLimit, kLimit) - base[c]);
        // Residuals of unused vertices are arbitrary within the limit.
        *largest =
            std::max(*largest, needed[k] ? std::abs(residuals_q12.back())
                                         : std::abs(base[c]) - kLimit + 1);
      }
    }
  }
  return residuals_q12;
}

}  // namespace

bool QuantizeSagittas(const Blocks& blocks,
                      const std::vector<NodePositions>& nodes,
                      std::vector<RemapTable>* tables) {
  for (RemapTable& table : *tables) {
    table.bends.clear();
    table.section.bend_shift = 0;
  }
  if (!blocks.layout.HasCurvedEdges()) return true;
  const std::vector<bool> needed = FindRequiredNodes(blocks);
  const double unit = kVertexUnits * std::ldexp(4, blocks.layout.part_log2 -
                                                       blocks.size_log2());
  const auto value = [&](size_t t, int node, int c) {
    return needed[node] ? unit * nodes[t](node, c) : 0.0;
  };
  double largest = 0;
  for (size_t t = 0; t < nodes.size(); ++t)
    for (int k = blocks.num_vertices(); k < blocks.num_nodes(); ++k)
      for (int c = 0; c < 2; ++c)
        largest = std::max(largest, std::abs(value(t, k, c)));
  const int shift = FittingShift(largest, 127);
  if (shift > static_cast<int>(RG_MAX_BEND_SHIFT)) return false;
  for (size_t t = 0; t < nodes.size(); ++t) {
    RemapTable& table = (*tables)[t];
    table.section.bend_shift = static_cast<uint8_t>(shift);
    for (int j = 0; j <= blocks.rows; ++j)
      for (int i = 0; i <= blocks.columns; ++i)
        for (const int bend :
             {blocks.LeftSagittaIndex(i, j), blocks.UpperSagittaIndex(i, j)})
          for (int c = 0; c < 2; ++c)
            table.bends.push_back(static_cast<int8_t>(
                std::lround(value(t, bend, c) / (1 << shift))));
  }
  return true;
}

bool QuantizeVertices(const Blocks& blocks,
                      const std::vector<NodePositions>& vertices,
                      std::vector<RemapTable>* tables) {
  QuantizePlane(blocks, vertices, tables);
  std::vector<std::vector<double>> residuals_q12;
  double largest = 0;
  for (size_t t = 0; t < vertices.size(); ++t)
    residuals_q12.push_back(
        ResidualsQ12(blocks, vertices[t], (*tables)[t].section, &largest));
  const int shift = FittingShift(largest, 32766);
  if (shift > static_cast<int>(RG_MAX_RESIDUAL_SHIFT)) return false;
  for (size_t t = 0; t < vertices.size(); ++t) {
    RemapTable& table = (*tables)[t];
    table.section.residual_shift = static_cast<uint8_t>(shift);
    table.residuals.clear();
    for (size_t k = 0; k < residuals_q12[t].size(); ++k) {
      const int vertex = static_cast<int>(k / 2);
      table.residuals.push_back(
          RoundedResidual(residuals_q12[t][k],
                          BaseQ12(table.section, vertex % (blocks.columns + 1),
                                  vertex / (blocks.columns + 1), k % 2),
                          shift));
    }
  }
  return true;
}

}  // namespace raygrid
