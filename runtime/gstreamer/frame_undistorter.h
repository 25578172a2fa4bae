/// Undistortion of GStreamer buffers.
#ifndef RAYGRID_GSTREAMER_FRAME_UNDISTORTER_H
#define RAYGRID_GSTREAMER_FRAME_UNDISTORTER_H

#include <gst/gst.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "band_remap.h"
#include "blob_file.h"
#include "caps.h"
#include "invalid_blocks.h"

namespace raygrid {

/// The values of the element's properties.
struct UndistortSettings {
  std::string blob;
  int table = -1;  ///< index; -1: the first one for the frame size
  bool is_enabled = true;
  bool only_valid = false;
  rg_border border = RG_BORDER_VALUE;
  rg_sampling sampling = RG_SAMPLING_BILINEAR;
  unsigned num_threads = 1;  ///< 0: one per processor
};

/// A blob, and the fixed caps of its table's input and output frames.
class FrameUndistorter {
 public:
  /// Throws CameraError if the blob is unusable.
  explicit FrameUndistorter(const UndistortSettings& settings);

  /// The frame sizes of all tables.
  const std::vector<TableSizes>& tables() const { return tables_; }

  /// Throws CameraError if no table accepts frames of this size.
  void RequireTableFor(const GstCaps* frames) const;

  /// Throws CameraError if no table matches the caps.
  void SetCaps(const GstCaps* frames, const GstCaps* views);

  /// Sets the lens position or temperature of the blob's operating-point model.
  /// Throws CameraError if the blob has none.
  void SetOperatingPoint(double value) { blob_.SetOperatingPoint(value); }

  /// Undistorts a frame, using the strides and offsets of both buffers, after
  /// SetCaps(). Throws CameraError.
  void Undistort(GstBuffer* frame, GstBuffer* view);

  /// Transforms the regions of interest that are visible in the view to it.
  void MoveRegions(GstBuffer* frame, GstBuffer* view) const;

 private:
  const UndistortSettings settings_;
  BlobFile blob_;
  const std::vector<TableSizes> tables_;
  BandRemap bands_;
  std::optional<FrameLayout> frames_, views_;
  std::optional<InvalidBlocks> invalid_;  // blocks to fill with border
};

}  // namespace raygrid

#endif  // RAYGRID_GSTREAMER_FRAME_UNDISTORTER_H
