/// Undistorts GStreamer's buffers.
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
#include "untrusted_blocks.h"

namespace raygrid {

/// The values of the element's properties.
struct UndistortSettings {
  std::string blob;
  int table = -1;  ///< -1: the first one for the frames' size
  bool is_enabled = true;
  bool only_trusted = false;
  rg_border border = RG_BORDER_VALUE;
  rg_sampling sampling = RG_SAMPLING_BILINEAR;
  unsigned num_threads = 1;  ///< 0: one for each processor
};

/// A blob, and frames of fixed caps that its table takes and makes.
class FrameUndistorter {
 public:
  /// Throws CameraError if the blob cannot be used.
  explicit FrameUndistorter(const UndistortSettings& settings);

  /// Sizes of all tables that frames may have.
  const std::vector<TableSizes>& tables() const { return tables_; }

  /// Throws CameraError if no table takes frames of their size.
  void RequireTableFor(const GstCaps* frames) const;

  /// Throws CameraError if no table is for them.
  void SetCaps(const GstCaps* frames, const GstCaps* views);

  /// Makes the camera that of a lens position, or temperature, of the blob's
  /// stack. Throws CameraError if the blob has none.
  void SetCondition(double value) { blob_.SetCondition(value); }

  /// Undistorts a frame, with the strides and offsets of both buffers. Caps are
  /// set. Throws CameraError.
  void Undistort(GstBuffer* frame, GstBuffer* view);

  /// Gives a view the regions of interest of its frame, where it shows them.
  void MoveRegions(GstBuffer* frame, GstBuffer* view) const;

 private:
  const UndistortSettings settings_;
  BlobFile blob_;
  const std::vector<TableSizes> tables_;
  BandRemap bands_;
  std::optional<FrameLayout> frames_, views_;
  std::optional<UntrustedBlocks> untrusted_;  // that become border
};

}  // namespace raygrid

#endif  // RAYGRID_GSTREAMER_FRAME_UNDISTORTER_H
