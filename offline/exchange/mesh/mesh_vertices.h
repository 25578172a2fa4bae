#ifndef RAYGRID_EXCHANGE_MESH_MESH_VERTICES_H
#define RAYGRID_EXCHANGE_MESH_MESH_VERTICES_H

#include <Eigen/Core>
#include <vector>

#include "exchange/mesh/mesh.h"

namespace raygrid {

/// A vertex is needed if the pixel at it has a source, or one in a cell that it
/// is a corner of. Sources are those of all pixels of a view of this size, and
/// NaN where there is none.
std::vector<bool> FindRequiredVertices(
    const MeshLattice& lattice, const ImageSize& size,
    const std::vector<Eigen::Vector2d>& sources);

/// Gives each vertex that is not finite a place, in line with those beside it.
/// At least one of them is finite.
void ExtrapolateVertices(const MeshLattice& lattice,
                         std::vector<Eigen::Vector2d>* vertices);

/// Moves vertices so that between them places lie on both sides of the view's.
/// Vertices that lie on it leave about twice the error.
void BalanceVertices(MeshTable* mesh);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_MESH_MESH_VERTICES_H
