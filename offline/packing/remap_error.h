#ifndef RAYGRID_PACKING_REMAP_ERROR_H
#define RAYGRID_PACKING_REMAP_ERROR_H

#include <optional>
#include <vector>

#include "camera/camera_model.h"
#include "packing/remap_blocks.h"
#include "packing/remap_fitting.h"
#include "packing/source_map.h"

namespace raygrid {

/// Computes the maximum error of a table over all output pixels, px, in the
/// runtime's integer arithmetic: the distance of a pixel's position from its
/// exact source; for a pixel without a source, the distance of its position
/// from the rectangle's edge if inside. nullopt if it exceeds the limit.
/// Deterministic for any number of threads.
std::optional<double> ComputeMaxRemapError(const CameraModel& camera,
                                           const OutputImage& output,
                                           const SourceMap& map,
                                           const Blocks& blocks,
                                           const RemapTable& table,
                                           double limit_px, int num_threads);

/// Returns, row by row, the blocks in which this error exceeds a limit, as
/// computed from the map. Blocks have tiles of equal size.
std::vector<bool> FindBlocksAboveError(const CameraModel& camera,
                                       const OutputImage& output,
                                       const SourceMap& map,
                                       const Blocks& blocks,
                                       const RemapTable& table, double limit_px,
                                       int num_threads);

/// Computes the maximum error of U and V in NV12 and YUYV, in chroma pixels,
/// from the map.
double ComputeMaxChromaError(const SourceMap& map, const RemapTable& table,
                             int num_threads);

/// Computes a lower bound of the maximum error of any table with this tile
/// size: the error of the best bilinear function at the corners, edge midpoints
/// and centre of each tile.
double ComputeMinRemapError(const SourceMap& map, int part_log2);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_REMAP_ERROR_H
