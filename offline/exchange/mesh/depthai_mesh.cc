#include <fmt/format.h>

#include <cstring>

#include "dataset/error.h"
#include "exchange/mesh/mesh_units.h"

namespace raygrid {
namespace {

constexpr int kDepthAiStep = 16;
constexpr MeshSides kDepthAiWidth = {16, 8192, 16}, kDepthAiHeight = {16, 8192};

MeshLattice MakeDepthAiLattice(const MeshRequest& request) {
  RequireMeshSize("depthai-mesh", "view", request.size, kDepthAiWidth,
                  kDepthAiHeight);
  const int step = request.step.value_or(kDepthAiStep);
  if (request.size.width % step != 0 || request.size.height % step != 0)
    throw Error(ExitCode::kUsage,
                fmt::format("--stride {}: must divide the size of the "
                            "undistorted view, {} x {} px, for depthai-mesh",
                            step, request.size.width, request.size.height));
  return MakeRegularLattice(request.size, step, step);
}

float AppendFloat(double value, std::string* bytes) {
  const float number = static_cast<float>(value);
  uint32_t bits;
  std::memcpy(&bits, &number, sizeof(bits));
  AppendLittleEndian(bits, sizeof(bits), bytes);
  return number;
}

UnitMesh WriteDepthAi(const MeshTable& mesh) {
  UnitMesh unit;
  std::string bytes;
  for (const Eigen::Vector2d& vertex : mesh.vertices) {
    const Eigen::Vector2d position = ToMeshUnit(vertex);
    const float y = AppendFloat(position.y(), &bytes),
                x = AppendFloat(position.x(), &bytes);
    unit.vertices.push_back(FromMeshUnit({x, y}));
  }
  unit.files = {{mesh.path, bytes}};
  unit.configuration =
      fmt::format("StereoDepth: setMeshStep({0}, {0})", mesh.lattice.x[1]);
  return unit;
}

}  // namespace

TableFormat MakeDepthAiMeshFormat() {
  static const MeshUnit unit = {MakeDepthAiLattice, WriteDepthAi, {}, ""};
  return MakeMeshFormat(
      "depthai-mesh",
      "Luxonis: mesh for loadMeshFiles() of StereoDepth, as .bin",
      {".bin", ".calib"}, {"rectified", "stride", "max-fit-error-px"}, &unit);
}

}  // namespace raygrid
