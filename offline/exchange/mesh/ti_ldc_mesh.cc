#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "dataset/error.h"
#include "exchange/mesh/mesh_units.h"

namespace raygrid {
namespace {

constexpr int kLdcScale = 8, kLdcDefaultStep = 16, kLdcMaxStep = 128;
constexpr int kLdcLineVertices = 16;  // row length is a multiple
constexpr MeshSides kLdcSides = {16, 8192, 2};
constexpr int kLdcMaxPad = 15;

MeshLattice MakeLdcLattice(const MeshRequest& request) {
  RequireMeshSize("ti-ldc", "view", request.size, kLdcSides, kLdcSides);
  RequireMeshSize("ti-ldc", "camera's image", request.source_size, kLdcSides,
                  kLdcSides);
  const int step = request.step.value_or(kLdcDefaultStep);
  if (step > kLdcMaxStep || (step & (step - 1)) != 0)
    throw Error(
        ExitCode::kUsage,
        fmt::format("--stride {}: must be a power of 2 up to {} for ti-ldc",
                    step, kLdcMaxStep));
  return MakeRegularLattice(request.size, step, step);
}

// Returns an offset as a 16-bit fixed-point number with 3 fractional bits.
// axis: for the error message.
int64_t LdcOffset(const MeshTable& mesh, size_t k, double offset, char axis) {
  const int64_t fixed = FixedPoint(offset, kLdcScale, INT16_MIN, INT16_MAX);
  if (mesh.is_needed[k] && std::abs(fixed - offset * kLdcScale) > 1)
    throw Error(
        ExitCode::kQualityTooLow,
        fmt::format(
            "--to ti-ldc: pixel {}, {} of the undistorted view has a "
            "displacement of {:.0f} px along {}, above the limit of 4095 px",
            mesh.lattice.x[k % mesh.lattice.columns()],
            mesh.lattice.y[k / mesh.lattice.columns()], offset, axis));
  return fixed;
}

// Returns by how many pixels the source positions of a block extend outside the
// bounding box of its corners' positions, maximum over all blocks.
double LdcExcess(const MeshTable& mesh,
                 const std::vector<Eigen::Vector2d>& positions, int block_px) {
  const int columns = mesh.lattice.columns(), rows = mesh.lattice.rows(),
            step = mesh.lattice.x[1], cells = std::max(block_px / step, 1);
  double excess = 0;
  for (int row = 0; row + 1 < rows; row += cells)
    for (int column = 0; column + 1 < columns; column += cells) {
      const int right = std::min(column + cells, columns - 1),
                below = std::min(row + cells, rows - 1);
      const auto at = [&](int i, int j) -> const Eigen::Vector2d& {
        return positions[static_cast<size_t>(j) * columns + i];
      };
      Eigen::AlignedBox2d box(at(column, row));
      box.extend(at(right, row));
      box.extend(at(column, below));
      box.extend(at(right, below));
      // Interpolated positions lie within the bounding box of the vertices.
      for (int j = row; j <= below; ++j)
        for (int i = column; i <= right; ++i)
          excess = std::max({excess, (box.min() - at(i, j)).maxCoeff(),
                             (at(i, j) - box.max()).maxCoeff()});
    }
  return excess;
}

// Returns the properties of TI's GStreamer element, with the largest block size
// whose padding the engine supports. Blocks within a cell need a padding of 1
// px for interpolation.
std::string LdcProperties(const MeshTable& mesh,
                          const std::vector<Eigen::Vector2d>& positions) {
  const int step = mesh.lattice.x[1];
  int block_px = 64;
  double pad = 0;
  for (;; block_px /= 2) {
    pad = std::ceil(LdcExcess(mesh, positions, block_px)) + 1;
    if (pad <= kLdcMaxPad) break;
  }
  return fmt::format(
      "tiovxldc ldc-table-width={} ldc-table-height={} ldc-ds-factor={} "
      "out-block-width={} out-block-height={} pixel-pad={}",
      mesh.size.width, mesh.size.height, std::lround(std::log2(step)), block_px,
      block_px, pad);
}

UnitMesh WriteLdc(const MeshTable& mesh) {
  UnitMesh unit;
  std::string bytes;
  const int columns = mesh.lattice.columns();
  for (int row = 0; row < mesh.lattice.rows(); ++row) {
    for (int column = 0; column < columns; ++column) {
      const size_t k = static_cast<size_t>(row) * columns + column;
      const Eigen::Vector2d own(mesh.lattice.x[column], mesh.lattice.y[row]);
      const Eigen::Vector2d offset = ToMeshUnit(mesh.vertices[k]) - own;
      const int64_t dx = LdcOffset(mesh, k, offset.x(), 'x'),
                    dy = LdcOffset(mesh, k, offset.y(), 'y');
      // The lower 16 bits contain y.
      AppendLittleEndian(static_cast<uint64_t>(dy), 2, &bytes);
      AppendLittleEndian(static_cast<uint64_t>(dx), 2, &bytes);
      unit.vertices.push_back(
          FromMeshUnit(own + Eigen::Vector2d(dx, dy) / kLdcScale));
    }
    for (int k = columns; k % kLdcLineVertices != 0; ++k)
      AppendLittleEndian(0, 4, &bytes);
  }
  unit.files = {{mesh.path, bytes}};
  unit.configuration = LdcProperties(mesh, unit.vertices);
  return unit;
}

}  // namespace

TableFormat MakeTiLdcFormat() {
  static const MeshUnit unit = {MakeLdcLattice, WriteLdc, {}, ""};
  return MakeMeshFormat(
      "ti-ldc",
      "TI TDA4, AM62A, AM67A, AM68A: mesh of the lens distortion correction "
      "unit, as .bin",
      {".bin"}, {"rectified", "stride", "max-fit-error-px"}, &unit);
}

}  // namespace raygrid
