#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "exchange/mesh/mesh_units.h"

namespace raygrid {
namespace {

constexpr int kFecScale = 256, kFecAlignment = 32, kFecBandRows = 128;
// Widest output image for which the engine uses the small cells.
constexpr int kFecSmallWidth = 1920;
constexpr MeshSides kFecSides = {32, 8192, 2};

int FecAligned(int pixels) {
  return (pixels + kFecAlignment - 1) / kFecAlignment * kFecAlignment;
}

// The engine pads its output to multiples of 32 pixels.
MeshLattice MakeFecLattice(const MeshRequest& request) {
  RequireMeshSize("rockchip-fec", "view", request.size, kFecSides, kFecSides);
  RequireMeshSize("rockchip-fec", "camera's image", request.source_size,
                  kFecSides, kFecSides);
  const bool is_small = request.size.width <= kFecSmallWidth;
  return MakeRegularLattice(
      {FecAligned(request.size.width), FecAligned(request.size.height)},
      is_small ? 16 : 32, is_small ? 8 : 16);
}

// Returns the vertex indices in the order of the engine: bands of 128 pixel
// rows, column-major within a band. The last row of vertices of a band is
// repeated as the first row of the next one.
std::vector<size_t> FecOrder(const MeshLattice& lattice) {
  const int per_band = kFecBandRows / lattice.y[1];
  std::vector<size_t> order;
  for (int first = 0; first + 1 < lattice.rows(); first += per_band) {
    const int last = std::min(first + per_band, lattice.rows() - 1);
    for (int column = 0; column < lattice.columns(); ++column)
      for (int row = first; row <= last; ++row)
        order.push_back(static_cast<size_t>(row) * lattice.columns() + column);
  }
  return order;
}

UnitMesh WriteFec(const MeshTable& mesh) {
  const std::array<int64_t, 2> most = {
      (mesh.source_size.width - 1) * kFecScale,
      (mesh.source_size.height - 1) * kFecScale};
  UnitMesh unit;
  std::vector<std::array<int64_t, 2>> fixed;
  for (const Eigen::Vector2d& vertex : mesh.vertices) {
    const Eigen::Vector2d position = ToMeshUnit(vertex);
    fixed.push_back({FixedPoint(position.x(), kFecScale, 0, most[0]),
                     FixedPoint(position.y(), kFecScale, 0, most[1])});
    unit.vertices.push_back(FromMeshUnit(
        Eigen::Vector2d(fixed.back()[0], fixed.back()[1]) / kFecScale));
  }
  const std::vector<size_t> order = FecOrder(mesh.lattice);
  for (int axis = 0; axis < 2; ++axis) {
    std::string whole, fraction;
    for (const size_t k : order) {
      AppendLittleEndian(fixed[k][axis] / kFecScale, 2, &whole);
      AppendLittleEndian(fixed[k][axis] % kFecScale, 1, &fraction);
    }
    const std::string name = axis == 0 ? "x" : "y";
    unit.files.emplace_back(PathWithSuffix(mesh.path, "_mesh" + name + "i"),
                            whole);
    unit.files.emplace_back(PathWithSuffix(mesh.path, "_mesh" + name + "f"),
                            fraction);
  }
  unit.configuration = fmt::format(
      "{} vertices in each of meshxi, meshxf, meshyi and "
      "meshyf",
      order.size());
  return unit;
}

}  // namespace

TableFormat MakeRockchipFecFormat() {
  static const MeshUnit unit = {MakeFecLattice, WriteFec, {}, ""};
  return MakeMeshFormat(
      "rockchip-fec",
      "Rockchip RV1126, RK3588: the four meshes of the fisheye correction "
      "unit, NAME_mesh{xi,xf,yi,yf}.bin",
      {".bin"}, {"rectified", "max-fit-error-px"}, &unit);
}

}  // namespace raygrid
