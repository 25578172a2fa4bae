#ifndef RAYGRID_PACKING_REMAP_ERROR_H
#define RAYGRID_PACKING_REMAP_ERROR_H

#include <optional>
#include <vector>

#include "camera/camera_model.h"
#include "packing/remap_blocks.h"
#include "packing/remap_fitting.h"
#include "packing/source_map.h"

namespace raygrid {

/// The worst error of a table over all output pixels, px, with the integers of
/// the board: the distance of a pixel's position from its exact source; for a
/// pixel without a source, how far inside the rectangle the table puts it.
/// Nothing if it is above the limit. The same with any number of threads.
std::optional<double> WorstRemapError(const CameraModel& camera,
                                      const OutputImage& output,
                                      const SourceMap& map,
                                      const Blocks& blocks,
                                      const RemapTable& table, double limit_px,
                                      int num_threads);

/// The blocks, all of them parts, in which an error as above is beyond a limit,
/// by the map; row by row.
std::vector<bool> BlocksBeyond(const CameraModel& camera,
                               const OutputImage& output, const SourceMap& map,
                               const Blocks& blocks, const RemapTable& table,
                               double limit_px, int num_threads);

/// The worst error of U and V in NV12 and YUYV, in their own pixels, by the
/// map.
double WorstChromaError(const SourceMap& map, const RemapTable& table,
                        int num_threads);

/// No table with parts of a size has a smaller worst error: no bilinear
/// function is closer to the sources at the corners, the edges' middles and the
/// centre of each part.
double LeastRemapError(const SourceMap& map, int part_log2);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_REMAP_ERROR_H
