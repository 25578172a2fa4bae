#include <fmt/format.h>

#include "exchange/mesh/mesh_units.h"

namespace raygrid {
namespace {

constexpr int kDw100Cell = 16, kDw100Scale = 16;
constexpr MeshSides kDw100Width = {176, 4096, 8}, kDw100Height = {144, 3072, 8};

// The last column and row of vertices lie on the border of the output image, as
// the dw100 driver and libcamera expect.
MeshLattice MakeDw100Lattice(const MeshRequest& request) {
  RequireMeshSize("dw100", "view", request.size, kDw100Width, kDw100Height);
  RequireMeshSize("dw100", "camera's image", request.source_size, kDw100Width,
                  kDw100Height);
  MeshLattice lattice =
      MakeRegularLattice(request.size, kDw100Cell, kDw100Cell);
  lattice.x.back() = request.size.width;
  lattice.y.back() = request.size.height;
  return lattice;
}

UnitMesh WriteDw100(const MeshTable& mesh) {
  UnitMesh unit;
  std::string bytes;
  for (const Eigen::Vector2d& vertex : mesh.vertices) {
    const Eigen::Vector2d position = ToMeshUnit(vertex);
    const int64_t x = FixedPoint(position.x(), kDw100Scale, 0, UINT16_MAX),
                  y = FixedPoint(position.y(), kDw100Scale, 0, UINT16_MAX);
    AppendLittleEndian(x, 2, &bytes);
    AppendLittleEndian(y, 2, &bytes);
    unit.vertices.push_back(FromMeshUnit(Eigen::Vector2d(x, y) / kDw100Scale));
  }
  unit.files = {{mesh.path, bytes}};
  unit.configuration = "V4L2_CID_DW100_DEWARPING_16x16_VERTEX_MAP";
  return unit;
}

}  // namespace

TableFormat MakeDw100Format() {
  static const MeshUnit unit = {MakeDw100Lattice, WriteDw100, {}, ""};
  return MakeMeshFormat(
      "dw100", "NXP i.MX 8M Plus: vertex map of the dw100 dewarper, as .bin",
      {".bin"}, {"rectified", "max-fit-error-px"}, &unit);
}

}  // namespace raygrid
