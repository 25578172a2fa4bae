/// Conversion between GStreamer's caps and the runtime's formats.
#ifndef RAYGRID_GSTREAMER_CAPS_H
#define RAYGRID_GSTREAMER_CAPS_H

#include <gst/gst.h>
#include <gst/video/video.h>

#include <optional>
#include <vector>

#include "raygrid.h"
#include "stream_format.h"

namespace raygrid {

/// Returns caps of all supported formats, of any size. The caller owns them.
GstCaps* TemplateCaps();

/// Frames of fixed caps: their memory layout unless a buffer overrides it.
struct FrameLayout {
  StreamFormat format;
  GstVideoInfo info;  ///< unset for Bayer, which GstVideoInfo lacks
  bool is_bayer = false;
  size_t num_bytes = 0;
};

/// Returns nullopt if the runtime does not support the format, or the size.
std::optional<FrameLayout> ParseLayout(const GstCaps* caps);

/// The sizes of a remap table's input and output frames.
struct TableSizes {
  uint16_t frame_width, frame_height, view_width, view_height;

  bool operator==(const TableSizes& other) const {
    return frame_width == other.frame_width &&
           frame_height == other.frame_height &&
           view_width == other.view_width && view_height == other.view_height;
  }
};

/// Converts caps from one side of the tables to the other: to those of the
/// tables' input for GST_PAD_SRC, of their output for GST_PAD_SINK. Keeps the
/// order of the tables; omits those whose size differs from the given caps. The
/// caller owns the result.
GstCaps* ConvertCaps(GstPadDirection direction, const GstCaps* caps,
                     const std::vector<TableSizes>& tables);

/// Replaces the size in caps by any size. The caller owns the result.
GstCaps* MakeAnySizeCaps(const GstCaps* caps);

}  // namespace raygrid

#endif  // RAYGRID_GSTREAMER_CAPS_H
