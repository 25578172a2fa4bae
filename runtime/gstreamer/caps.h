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

/// Caps of all supported formats, of any size. To be unreferenced.
GstCaps* TemplateCaps();

/// Frames of fixed caps: their memory layout unless a buffer overrides it.
struct FrameLayout {
  StreamFormat format;
  GstVideoInfo info;  ///< not for Bayer, which GstVideoInfo lacks
  bool is_bayer = false;
  size_t num_bytes = 0;
};

/// Nothing if the runtime does not support the format, or the size.
std::optional<FrameLayout> LayoutOf(const GstCaps* caps);

/// The frame sizes of a blob's table: input and output.
struct TableSizes {
  uint16_t frame_width, frame_height, view_width, view_height;

  bool operator==(const TableSizes& other) const {
    return frame_width == other.frame_width &&
           frame_height == other.frame_height &&
           view_width == other.view_width && view_height == other.view_height;
  }
};

/// Caps on the other side of tables: of their output for GST_PAD_SINK, of their
/// input for GST_PAD_SRC. The first table's come first. To be unreferenced.
GstCaps* OtherSide(GstPadDirection direction, const GstCaps* caps,
                   const std::vector<TableSizes>& tables);

/// Replaces the size in caps by any size. To be unreferenced.
GstCaps* OfAnySize(const GstCaps* caps);

}  // namespace raygrid

#endif  // RAYGRID_GSTREAMER_CAPS_H
