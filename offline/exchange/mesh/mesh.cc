#include "exchange/mesh/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <tuple>

#include "dataset/error.h"

namespace raygrid {
namespace {

size_t CountInaccurate(const MeshTable& mesh, const UnitMesh& unit) {
  size_t count = 0;
  for (size_t k = 0; k < mesh.vertices.size(); ++k) {
    Eigen::Vector2d moved = unit.vertices[k] - mesh.vertices[k];
    if (unit.keeps_rows) moved.y() = 0;
    count += mesh.is_needed[k] && moved.cwiseAbs().maxCoeff() > 1;
  }
  return count;
}

// Interpolates the source position of a pixel with separable weights.
Eigen::Vector2d InterpolateByWeights(
    const MeshLattice& lattice, const std::vector<Eigen::Vector2d>& vertices,
    const MeshWeights& x, const MeshWeights& y) {
  Eigen::Vector2d position(0, 0);
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) {
      const double weight = x.weights[i] * y.weights[j];
      if (weight != 0)
        position +=
            weight *
            vertices[static_cast<size_t>(y.vertex + j) * lattice.columns() +
                     x.vertex + i];
    }
  return position;
}

}  // namespace

std::string GetInterpolationName(MeshInterpolation interpolation) {
  return interpolation == MeshInterpolation::kLine    ? "lines"
         : interpolation == MeshInterpolation::kPatch ? "patches"
                                                      : "nearest";
}

std::vector<MeshWeights> ComputeWeightsOnAxis(const std::vector<int>& vertices,
                                              int count,
                                              MeshInterpolation interpolation) {
  const int last = static_cast<int>(vertices.size()) - 1;
  std::vector<MeshWeights> all;
  for (const MeshStep& step : LocatePixelsOnAxis(vertices, count)) {
    if (interpolation == MeshInterpolation::kLine || last < 2) {
      all.push_back({step.vertex, {1 - step.part, step.part, 0}});
      continue;
    }
    const int center = std::clamp(interpolation == MeshInterpolation::kPatch
                                      ? step.vertex / 2 * 2 + 1
                                      : step.vertex + (step.part > 0.5),
                                  1, last - 1);
    const double t = step.vertex + step.part - center;
    all.push_back({center - 1, {t * (t - 1) / 2, 1 - t * t, t * (t + 1) / 2}});
  }
  return all;
}

std::vector<MeshStep> LocatePixelsOnAxis(const std::vector<int>& vertices,
                                         int count) {
  std::vector<MeshStep> steps(count);
  const int last_cell = static_cast<int>(vertices.size()) - 2;
  int k = 0;
  for (int pixel = 0; pixel < count; ++pixel) {
    while (k < last_cell && vertices[k + 1] <= pixel) ++k;
    steps[pixel].vertex = k;
    if (last_cell >= 0)
      steps[pixel].part = static_cast<double>(pixel - vertices[k]) /
                          (vertices[k + 1] - vertices[k]);
  }
  return steps;
}

Eigen::Vector2d MapToMesh(const MeshLattice& lattice,
                          const std::vector<Eigen::Vector2d>& vertices,
                          const MeshStep& x, const MeshStep& y) {
  const size_t first =
      static_cast<size_t>(y.vertex) * lattice.columns() + x.vertex;
  const size_t right = lattice.columns() > 1 ? 1 : 0,
               below = lattice.rows() > 1 ? lattice.columns() : 0;
  const Eigen::Vector2d above =
      vertices[first] + x.part * (vertices[first + right] - vertices[first]);
  const Eigen::Vector2d under =
      vertices[first + below] +
      x.part * (vertices[first + below + right] - vertices[first + below]);
  return above + y.part * (under - above);
}

MeshError ComputeMeshError(const MeshTable& mesh, const UnitMesh& unit,
                           MeshInterpolation interpolation) {
  const std::vector<MeshWeights> columns =
      ComputeWeightsOnAxis(mesh.lattice.x, mesh.size.width, interpolation);
  const std::vector<MeshWeights> rows =
      ComputeWeightsOnAxis(mesh.lattice.y, mesh.size.height, interpolation);
  const Area image = WholeImage(mesh.source_size);
  MeshError error;
  double sum = 0, worst = -1;
  for (int y = 0; y < mesh.size.height; ++y)
    for (int x = 0; x < mesh.size.width; ++x) {
      const Eigen::Vector2d position = InterpolateByWeights(
          mesh.lattice, unit.vertices, columns[x], rows[y]);
      const Eigen::Vector2d& source =
          mesh.sources[static_cast<size_t>(y) * mesh.size.width + x];
      if (!source.allFinite()) {
        error.num_filled += image.Contains(position);
        continue;
      }
      const double squared = (position - source).squaredNorm();
      sum += squared;
      ++error.num_pixels;
      if (squared <= worst) continue;
      worst = squared;
      error.x = x;
      error.y = y;
    }
  if (error.num_pixels > 0) {
    error.max_px = std::sqrt(worst);
    error.rms_px = std::sqrt(sum / error.num_pixels);
  }
  error.num_inaccurate = CountInaccurate(mesh, unit);
  return error;
}

std::string FormatMeshError(const MeshError& error) {
  std::string text =
      fmt::format("error {:.2g} px max (at {}, {}), {:.2g} px RMS",
                  error.max_px, error.x, error.y, error.rms_px);
  if (error.num_filled > 0)
    text += fmt::format(
        "; {} pixels that are empty in the undistorted view are filled",
        error.num_filled);
  if (error.num_inaccurate > 0)
    text += fmt::format(
        "; {} vertices outside the image are clamped to the range of the unit "
        "(avoid this with --alpha 0)",
        error.num_inaccurate);
  return text;
}

MeshLattice MakeRegularLattice(const ImageSize& size, int step_x, int step_y) {
  MeshLattice lattice;
  for (int x = 0; x < size.width + step_x; x += step_x) lattice.x.push_back(x);
  for (int y = 0; y < size.height + step_y; y += step_y) lattice.y.push_back(y);
  return lattice;
}

void RequireMeshSize(const std::string& unit, const std::string& what,
                     const ImageSize& size, const MeshSides& width,
                     const MeshSides& height) {
  for (const auto& [name, pixels, sides] :
       {std::tuple("width", size.width, width),
        {"height", size.height, height}})
    if (pixels < sides.min || pixels > sides.max ||
        pixels % sides.multiple != 0)
      throw Error(
          ExitCode::kUsage,
          fmt::format("--to {}: the {} of {} x {} px has a {} of {}; the unit "
                      "supports {} to {} px{}",
                      unit, what, size.width, size.height, name, pixels,
                      sides.min, sides.max,
                      sides.multiple > 1
                          ? fmt::format(", multiples of {}", sides.multiple)
                          : ""));
}

int64_t FixedPoint(double value, int scale, int64_t least, int64_t most) {
  const double scaled = std::round(value * scale);
  if (!(scaled > static_cast<double>(least))) return least;
  if (scaled > static_cast<double>(most)) return most;
  return static_cast<int64_t>(scaled);
}

void AppendLittleEndian(uint64_t number, int num_bytes, std::string* bytes) {
  for (int k = 0; k < num_bytes; ++k)
    bytes->push_back(static_cast<char>((number >> (8 * k)) & 255));
}

std::string PathWithSuffix(const std::string& path, const std::string& suffix) {
  const std::filesystem::path full_path(path);
  return (full_path.parent_path() /
          (full_path.stem().string() + suffix + full_path.extension().string()))
      .string();
}

}  // namespace raygrid
