#ifndef RAYGRID_PACKING_REMAP_FITTING_H
#define RAYGRID_PACKING_REMAP_FITTING_H

#include <cstdint>
#include <functional>
#include <vector>

#include "camera/camera_model.h"
#include "packing/view.h"
#include "rg_blob.h"

namespace raygrid {

/// A remap section and the arrays it points to.
struct RemapTable {
  VirtualView view;
  rg_remap_section section = {};
  std::vector<int16_t> residuals;
  std::vector<int8_t> bends;  ///< four a vertex, or none
  std::vector<uint8_t> empty_blocks;
  double max_error_px = 0;  ///< over all output pixels, in the board's integers
  /// The largest error of U and V in NV12 and YUYV, in their own pixels; not
  /// where their sources end.
  double max_chroma_error_px = 0;
  /// Blocks that are border since a corner lies beyond 8192 px.
  int num_out_of_reach = 0;
  /// Blocks that are border since the lens bends more there than the smallest
  /// blocks follow.
  int num_rough = 0;
};

/// The fate of a few blocks of 8 that do not keep the bound, up to 2 %:
/// tables are refused, or have border there.
enum class RoughBlocks { kRefuse, kLeaveOut };

/// Tells which pixels of a camera's image are shown; all, if it is empty.
using ShownPixels = std::function<bool(const Eigen::Vector2d& pixel)>;

/// The table with the largest parts of blocks, and of these the one with the
/// fewest bytes, whose geometric error is at most max_error_px: vertices and
/// bends are fitted to the sources of all pixels for about the least largest
/// error, quantised, and then measured with the arithmetic of the runtime. The
/// same with any number of threads. Source positions outside the calibrated
/// area become border. Throws Error(kQuality) if not even blocks of 8 keep the
/// bound, Error(kUsage) if the
/// images are too large for the format or the virtual camera sees nothing.
/// Blocks none of whose sources are shown become border, too. go_on is called
/// now and then, and may throw.
///
/// Of several cameras, which are one at several conditions: a table of each,
/// that only differ as those of a stack's knots do. A block is border if it is
/// with all of them.
std::vector<RemapTable> FitRemapTables(
    const std::vector<const CameraModel*>& cameras, const VirtualView& view,
    double max_error_px, int num_threads,
    const std::function<void()>& go_on = [] {}, const ShownPixels& shows = {},
    RoughBlocks rough = RoughBlocks::kRefuse);

/// The tables of the other direction, which distort: their output pixels are
/// those of the camera's image, their sources lie in the view's picture. The
/// section has the camera's size, a rectangle of sources within the view's
/// picture, and projection, K and rotation of the view. The bound holds for
/// calibrated pixels; others of the same blocks may show something. Throws as
/// FitRemapTables().
std::vector<RemapTable> FitDistortionTables(
    const std::vector<const CameraModel*>& cameras, const VirtualView& view,
    double max_error_px, int num_threads,
    const std::function<void()>& go_on = [] {}, const ShownPixels& shows = {},
    RoughBlocks rough = RoughBlocks::kRefuse);

/// The table of one camera.
inline RemapTable FitRemapTable(
    const CameraModel& camera, const VirtualView& view, double max_error_px,
    int num_threads, const std::function<void()>& go_on = [] {},
    const ShownPixels& shows = {}) {
  return FitRemapTables({&camera}, view, max_error_px, num_threads, go_on,
                        shows)
      .front();
}

inline RemapTable FitDistortionTable(
    const CameraModel& camera, const VirtualView& view, double max_error_px,
    int num_threads, const std::function<void()>& go_on = [] {},
    const ShownPixels& shows = {}) {
  return FitDistortionTables({&camera}, view, max_error_px, num_threads, go_on,
                             shows)
      .front();
}

}  // namespace raygrid

#endif  // RAYGRID_PACKING_REMAP_FITTING_H
