#include <fmt/format.h>

#include "exchange/mesh/mesh_units.h"

namespace raygrid {
namespace {

constexpr int kHailoCell = 64, kHailoScale = 1 << 16;
constexpr MeshSides kHailoSides = {64, 4095, 2};

MeshLattice MakeHailoLattice(const MeshRequest& request) {
  RequireMeshSize("hailo", "view", request.size, kHailoSides, kHailoSides);
  RequireMeshSize("hailo", "camera's image", request.source_size, kHailoSides,
                  kHailoSides);
  return MakeRegularLattice(request.size, kHailoCell, kHailoCell);
}

UnitMesh WriteHailo(const MeshTable& mesh) {
  UnitMesh unit;
  std::string bytes;
  for (const Eigen::Vector2d& vertex : mesh.vertices) {
    const Eigen::Vector2d position = ToMeshUnit(vertex);
    const int64_t x = FixedPoint(position.x(), kHailoScale, INT32_MIN,
                                 INT32_MAX),
                  y = FixedPoint(position.y(), kHailoScale, INT32_MIN,
                                 INT32_MAX);
    AppendLittleEndian(static_cast<uint64_t>(x), 4, &bytes);
    AppendLittleEndian(static_cast<uint64_t>(y), 4, &bytes);
    unit.vertices.push_back(FromMeshUnit(Eigen::Vector2d(x, y) / kHailoScale));
  }
  unit.files = {{mesh.path, bytes}};
  unit.configuration = fmt::format("mesh_width {}, mesh_height {}",
                                   mesh.lattice.columns(), mesh.lattice.rows());
  return unit;
}

}  // namespace

TableFormat MakeHailoFormat() {
  static const MeshUnit unit = {MakeHailoLattice, WriteHailo, {}, ""};
  return MakeMeshFormat("hailo",
                        "Hailo-15: mesh_table of dsp_dewarp(), as .bin",
                        {".bin"}, {"rectified", "max-fit-error-px"}, &unit);
}

}  // namespace raygrid
