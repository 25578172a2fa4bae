#include "exchange/mesh/mesh_vertices.h"

#include <optional>

namespace raygrid {
namespace {

// Read access to the vertices of a grid; positions that are not finite are
// unknown.
class VertexField {
 public:
  VertexField(const MeshLattice& lattice,
              std::vector<Eigen::Vector2d>* positions)
      : columns_(lattice.columns()),
        rows_(lattice.rows()),
        positions_(*positions) {}

  // Extrapolates an unknown vertex linearly from known neighbours, averaged
  // over the eight directions; nullopt if all neighbours are unknown.
  std::optional<Eigen::Vector2d> ExtrapolateLinearly(int column,
                                                     int row) const {
    Eigen::Vector2d sum(0, 0);
    int count = 0;
    for (int k = 0; k < 9; ++k) {
      const int dx = k % 3 - 1, dy = k / 3 - 1;
      const Eigen::Vector2d* const near = Find(column + dx, row + dy);
      if (!near) continue;
      const Eigen::Vector2d* const far = Find(column + 2 * dx, row + 2 * dy);
      sum += far ? 2 * *near - *far : *near;
      ++count;
    }
    if (count == 0) return std::nullopt;
    return sum / count;
  }

 private:
  const Eigen::Vector2d* Find(int column, int row) const {
    if (column < 0 || column >= columns_ || row < 0 || row >= rows_)
      return nullptr;
    const Eigen::Vector2d& position =
        positions_[static_cast<size_t>(row) * columns_ + column];
    return position.allFinite() ? &position : nullptr;
  }

  int columns_, rows_;
  const std::vector<Eigen::Vector2d>& positions_;
};

}  // namespace

std::vector<bool> FindRequiredVertices(
    const MeshLattice& lattice, const ImageSize& size,
    const std::vector<Eigen::Vector2d>& sources) {
  const std::vector<MeshStep> columns =
                                  LocatePixelsOnAxis(lattice.x, size.width),
                              rows = LocatePixelsOnAxis(lattice.y, size.height);
  const size_t width = lattice.columns();
  std::vector<bool> is_needed(lattice.num_vertices(), false);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      if (!sources[static_cast<size_t>(y) * size.width + x].allFinite())
        continue;
      const size_t first = rows[y].vertex * width + columns[x].vertex;
      // A pixel on a vertex or edge depends on one or two vertices only.
      const bool right = columns[x].part > 0, below = rows[y].part > 0;
      is_needed[first] = true;
      if (right) is_needed[first + 1] = true;
      if (below) is_needed[first + width] = true;
      if (right && below) is_needed[first + width + 1] = true;
    }
  return is_needed;
}

void ExtrapolateVertices(const MeshLattice& lattice,
                         std::vector<Eigen::Vector2d>* vertices) {
  std::vector<size_t> unknown;
  for (size_t k = 0; k < vertices->size(); ++k)
    if (!(*vertices)[k].allFinite()) unknown.push_back(k);
  // Extrapolates ring by ring, from the neighbours of known vertices outwards.
  while (!unknown.empty() && unknown.size() < vertices->size()) {
    const VertexField field(lattice, vertices);
    std::vector<std::pair<size_t, Eigen::Vector2d>> ring;
    std::vector<size_t> rest;
    for (const size_t k : unknown) {
      const auto position =
          field.ExtrapolateLinearly(static_cast<int>(k % lattice.columns()),
                                    static_cast<int>(k / lattice.columns()));
      if (position)
        ring.emplace_back(k, *position);
      else
        rest.push_back(k);
    }
    for (const auto& [k, position] : ring) (*vertices)[k] = position;
    unknown = std::move(rest);
  }
}

void BalanceVertices(MeshTable* mesh) {
  // If the function is quadratic, the error of linear interpolation is 0 at the
  // vertices and at most 3/2 of its mean between them. Subtracting half of this
  // maximum (3/4 of the mean) makes the errors symmetric about 0.
  constexpr double kPart = 0.75;
  const MeshLattice& lattice = mesh->lattice;
  const std::vector<MeshStep> columns = LocatePixelsOnAxis(lattice.x,
                                                           mesh->size.width),
                              rows = LocatePixelsOnAxis(lattice.y,
                                                        mesh->size.height);
  const size_t right = lattice.columns() > 1 ? 1 : 0,
               below = lattice.rows() > 1 ? lattice.columns() : 0;
  std::vector<Eigen::Vector3d> sums(lattice.num_vertices(),
                                    Eigen::Vector3d::Zero());
  for (int y = 0; y < mesh->size.height; ++y)
    for (int x = 0; x < mesh->size.width; ++x) {
      const Eigen::Vector2d& source =
          mesh->sources[static_cast<size_t>(y) * mesh->size.width + x];
      if (!source.allFinite()) continue;
      const MeshStep &i = columns[x], &j = rows[y];
      const Eigen::Vector2d error =
          MapToMesh(lattice, mesh->vertices, i, j) - source;
      const Eigen::Vector3d term(error.x(), error.y(), 1);
      const size_t first =
          static_cast<size_t>(j.vertex) * lattice.columns() + i.vertex;
      sums[first] += (1 - i.part) * (1 - j.part) * term;
      sums[first + right] += i.part * (1 - j.part) * term;
      sums[first + below] += (1 - i.part) * j.part * term;
      sums[first + below + right] += i.part * j.part * term;
    }
  for (size_t k = 0; k < sums.size(); ++k)
    if (sums[k].z() > 0)
      mesh->vertices[k] -= kPart * sums[k].head<2>() / sums[k].z();
}

}  // namespace raygrid
