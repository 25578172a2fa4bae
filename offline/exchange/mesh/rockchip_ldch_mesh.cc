#include <fmt/format.h>

#include "dataset/error.h"
#include "exchange/mesh/mesh_units.h"

namespace raygrid {
namespace {

constexpr int kLdchStepX = 16, kLdchStepY = 8, kLdchScale = 16;
constexpr MeshSides kLdchWidth = {32, 4096, kLdchStepX},
                    kLdchHeight = {16, 4096, kLdchStepY};

MeshLattice MakeLdchLattice(const MeshRequest& request) {
  RequireMeshSize("rockchip-ldch", "view", request.size, kLdchWidth,
                  kLdchHeight);
  if (request.size != request.source_size)
    throw Error(
        ExitCode::kUsage,
        fmt::format("--to rockchip-ldch: the unit cannot change the size of {} "
                    "x {} px; omit --size",
                    request.source_size.width, request.source_size.height));
  return MakeRegularLattice(request.size, kLdchStepX, kLdchStepY);
}

UnitMesh WriteLdch(const MeshTable& mesh) {
  const int columns = mesh.lattice.columns(), rows = mesh.lattice.rows(),
            line = columns + columns % 2;
  UnitMesh unit;
  unit.keeps_rows = true;
  std::string bytes;
  for (const int number :
       {mesh.size.width, mesh.size.height, line, rows, kLdchStepX, kLdchStepY})
    AppendLittleEndian(number, 2, &bytes);
  const int64_t most = (mesh.source_size.width - 1) * kLdchScale;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector2d position = ToMeshUnit(
          mesh.vertices[static_cast<size_t>(row) * columns + column]);
      const int64_t x = FixedPoint(position.x(), kLdchScale, 0, most);
      AppendLittleEndian(x, 2, &bytes);
      // The engine displaces pixels along x only.
      unit.vertices.push_back(FromMeshUnit(
          {static_cast<double>(x) / kLdchScale, mesh.lattice.y[row]}));
    }
    if (line > columns) AppendLittleEndian(0, 2, &bytes);
  }
  unit.files = {{mesh.path, bytes}};
  unit.configuration = "x alone";
  return unit;
}

}  // namespace

TableFormat MakeRockchipLdchFormat() {
  static const MeshUnit unit = {MakeLdchLattice, WriteLdch, 1.0,
                                "the unit displaces pixels along rows only; "
                                "use rockchip-fec for both axes"};
  return MakeMeshFormat(
      "rockchip-ldch",
      "Rockchip RV1126, RK356x, RK3588: mesh of the horizontal correction unit "
      "LDCH, as .bin",
      {".bin"}, {"rectified", "max-fit-error-px"}, &unit);
}

}  // namespace raygrid
