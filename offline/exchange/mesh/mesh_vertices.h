#ifndef RAYGRID_EXCHANGE_MESH_MESH_VERTICES_H
#define RAYGRID_EXCHANGE_MESH_MESH_VERTICES_H

#include <Eigen/Core>
#include <vector>

#include "exchange/mesh/mesh.h"

namespace raygrid {

/// Returns the vertices from which valid pixels are interpolated. sources: one
/// per output pixel, row-major; NaN if invalid.
std::vector<bool> FindRequiredVertices(
    const MeshLattice& lattice, const ImageSize& size,
    const std::vector<Eigen::Vector2d>& sources);

/// Extrapolates the vertices that are not finite from their neighbours. At
/// least one vertex must be finite.
void ExtrapolateVertices(const MeshLattice& lattice,
                         std::vector<Eigen::Vector2d>* vertices);

/// Shifts vertices such that the errors of bilinear interpolation have both
/// signs. With exact vertices the maximum error is about twice as large.
void BalanceVertices(MeshTable* mesh);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_MESH_MESH_VERTICES_H
