#include <fmt/format.h>

#include "exchange/mesh/mesh_units.h"
#include "exchange/npz.h"

namespace raygrid {
namespace {

constexpr MeshSides kVpiWidth = {64, 16384}, kVpiHeight = {16, 16384};

// Every pixel: how VPI goes on between fewer points is not written down.
MeshLattice VpiLattice(const MeshRequest& request) {
  RequireMeshSize("vpi", "view", request.size, kVpiWidth, kVpiHeight);
  MeshLattice lattice;
  for (int x = 0; x < request.size.width; ++x) lattice.x.push_back(x);
  for (int y = 0; y < request.size.height; ++y) lattice.y.push_back(y);
  return lattice;
}

UnitMesh WriteVpi(const MeshTable& mesh) {
  UnitMesh unit;
  std::vector<float> keypoints;
  for (const Eigen::Vector2d& vertex : mesh.vertices) {
    const Eigen::Vector2d place = ToMeshUnit(vertex);
    keypoints.push_back(static_cast<float>(place.x()));
    keypoints.push_back(static_cast<float>(place.y()));
    unit.vertices.push_back(
        FromMeshUnit({*(keypoints.end() - 2), keypoints.back()}));
  }
  const int32_t size[] = {mesh.size.width, mesh.size.height};
  const int32_t source_size[] = {mesh.source_size.width,
                                 mesh.source_size.height};
  unit.files = {
      {mesh.path,
       WriteNpz({MakeNpyArray("keypoints",
                              {static_cast<size_t>(mesh.lattice.rows()),
                               static_cast<size_t>(mesh.lattice.columns()), 2},
                              keypoints.data()),
                 MakeNpyArray("size", {2}, size),
                 MakeNpyArray("source_size", {2}, source_size)})}};
  unit.told = fmt::format("keypoints of vpi.WarpMap(vpi.WarpGrid(({}, {})))",
                          mesh.size.width, mesh.size.height);
  return unit;
}

}  // namespace

TableFormat VpiFormat() {
  static const MeshUnit unit = {VpiLattice, WriteVpi, {}, ""};
  TableFormat format;
  format.name = "vpi";
  format.holds = "NVIDIA VPI: the keypoints of a dense WarpMap, in .npz";
  format.endings = {".npz"};
  format.options = {"rectified", "max-fit-error"};
  format.mesh_unit = &unit;
  return format;
}

}  // namespace raygrid
