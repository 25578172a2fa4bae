#ifndef RAYGRID_PACKING_REMAP_FITTING_H
#define RAYGRID_PACKING_REMAP_FITTING_H

#include <cstdint>
#include <functional>
#include <vector>

#include "camera/camera_model.h"
#include "packing/view.h"
#include "rg_blob.h"

namespace raygrid {

/// A remap section and the arrays to which it points.
struct RemapTable {
  VirtualView view;
  rg_remap_section section = {};
  std::vector<int16_t> residuals;
  std::vector<int8_t> bends;  ///< four per vertex, or empty
  std::vector<uint8_t> empty_blocks;
  double max_error_px = 0;  ///< maximum over all output pixels
  /// Maximum error of U and V in NV12 and YUYV, in chroma pixels; except at the
  /// edges of their sources.
  double max_chroma_error_px = 0;
  /// Number of border blocks with a vertex outside the format's range.
  int num_out_of_range = 0;
  /// Number of blocks that are border because even the smallest blocks exceed
  /// the error limit.
  int num_inaccurate_blocks = 0;
};

/// Treatment of blocks of 8 px that exceed the error limit, if they are at most
/// 2 % of all blocks: an error, or border.
enum class InaccurateBlocks { kReject, kExclude };

/// Whether a pixel of a camera's image is shown; empty: all pixels are shown.
using PixelFilter = std::function<bool(const Eigen::Vector2d& pixel)>;

/// Fits the table with the largest tiles, and of these the fewest bytes, whose
/// geometric error is at most max_error_px: vertices and bends approximately
/// minimize the maximum error over all pixels, are quantized, and then measured
/// in the runtime's arithmetic. Deterministic for any number of threads.
/// Sources outside the calibrated area become border. Throws
/// Error(kQualityTooLow) if blocks of 8 px exceed the limit, and Error(kUsage)
/// if the images are too large for the format or the view does not overlap the
/// calibrated area. Blocks without any shown source become border, too. go_on
/// is called regularly and may throw, to cancel the fit.
///
/// For several cameras, at different operating points of one camera: one table
/// each, which differ only in residuals, bends and errors. A block is border if
/// it is border for all cameras.
std::vector<RemapTable> FitRemapTables(
    const std::vector<const CameraModel*>& cameras, const VirtualView& view,
    double max_error_px, int num_threads,
    const std::function<void()>& go_on = [] {}, const PixelFilter& shows = {},
    InaccurateBlocks rough = InaccurateBlocks::kReject);

/// Fits inverse tables, which distort: output pixels are those of the camera's
/// image, sources are in the view's image. The section has the camera's size, a
/// source rectangle within the view's image, and projection, K and rotation of
/// the view. The error limit applies to calibrated pixels; other pixels in the
/// same blocks are undefined. Throws like FitRemapTables().
std::vector<RemapTable> FitDistortionTables(
    const std::vector<const CameraModel*>& cameras, const VirtualView& view,
    double max_error_px, int num_threads,
    const std::function<void()>& go_on = [] {}, const PixelFilter& shows = {},
    InaccurateBlocks rough = InaccurateBlocks::kReject);

/// Fits the table of one camera.
inline RemapTable FitRemapTable(
    const CameraModel& camera, const VirtualView& view, double max_error_px,
    int num_threads, const std::function<void()>& go_on = [] {},
    const PixelFilter& shows = {}) {
  return FitRemapTables({&camera}, view, max_error_px, num_threads, go_on,
                        shows)
      .front();
}

inline RemapTable FitDistortionTable(
    const CameraModel& camera, const VirtualView& view, double max_error_px,
    int num_threads, const std::function<void()>& go_on = [] {},
    const PixelFilter& shows = {}) {
  return FitDistortionTables({&camera}, view, max_error_px, num_threads, go_on,
                             shows)
      .front();
}

}  // namespace raygrid

#endif  // RAYGRID_PACKING_REMAP_FITTING_H
