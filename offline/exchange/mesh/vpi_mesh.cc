#include <fmt/format.h>

#include "dataset/error.h"
#include "exchange/mesh/mesh_units.h"
#include "exchange/npz.h"

namespace raygrid {
namespace {

constexpr MeshSides kVpiWidth = {64, 16384}, kVpiHeight = {16, 16384};

constexpr int kVpiMaxStep = 64, kVpiTileWidth = 64, kVpiTileHeight = 16;

// Returns the grid points along an axis that is processed in tiles. The count
// is odd and the last point is not before the end of the last tile.
std::vector<int> VpiPoints(int num_pixels, int tile, int step) {
  const int end = (num_pixels + tile - 1) / tile * tile;
  int count = (end + step - 1) / step + 1;
  if (count % 2 == 0) ++count;
  std::vector<int> points(count);
  for (int k = 0; k < count; ++k) points[k] = k * step;
  return points;
}

// One vertex per pixel unless --stride is given.
MeshLattice MakeVpiLattice(const MeshRequest& request) {
  RequireMeshSize("vpi", "view", request.size, kVpiWidth, kVpiHeight);
  const int step = request.step.value_or(1);
  if (step > kVpiMaxStep || (step & (step - 1)) != 0)
    throw Error(
        ExitCode::kUsage,
        fmt::format("--stride {}: must be a power of 2 up to {} for vpi", step,
                    kVpiMaxStep));
  MeshLattice lattice;
  if (step > 1) {
    lattice.x = VpiPoints(request.size.width, kVpiTileWidth, step);
    lattice.y = VpiPoints(request.size.height, kVpiTileHeight, step);
    return lattice;
  }
  for (int x = 0; x < request.size.width; ++x) lattice.x.push_back(x);
  for (int y = 0; y < request.size.height; ++y) lattice.y.push_back(y);
  return lattice;
}

UnitMesh WriteVpi(const MeshTable& mesh) {
  UnitMesh unit;
  std::vector<float> keypoints;
  for (const Eigen::Vector2d& vertex : mesh.vertices) {
    const Eigen::Vector2d position = ToMeshUnit(vertex);
    keypoints.push_back(static_cast<float>(position.x()));
    keypoints.push_back(static_cast<float>(position.y()));
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
  unit.configuration = fmt::format(
      "keypoints of vpi.WarpMap(vpi.WarpGrid(({}, {}), {})); its number of "
      "columns and rows may differ",
      mesh.size.width, mesh.size.height, mesh.lattice.x[1]);
  return unit;
}

}  // namespace

TableFormat MakeVpiFormat() {
  static const MeshUnit unit = {
      MakeVpiLattice,
      WriteVpi,
      {},
      "",
      {MeshInterpolation::kPatch, MeshInterpolation::kNearest,
       MeshInterpolation::kLine}};
  return MakeMeshFormat(
      "vpi",
      "NVIDIA VPI: keypoints of a WarpMap, dense, or sparse with --stride, as "
      ".npz",
      {".npz"}, {"rectified", "max-fit-error-px", "stride"}, &unit);
}

}  // namespace raygrid
