/// GStreamer's caps and the runtime's formats.
#ifndef RAYGRID_GSTREAMER_CAPS_H
#define RAYGRID_GSTREAMER_CAPS_H

#include <gst/gst.h>
#include <gst/video/video.h>

#include <optional>
#include <vector>

#include "raygrid.h"
#include "stream_format.h"

namespace raygrid {

/// Caps of all formats that are undistorted, of any size. To be unreferenced.
GstCaps* TemplateCaps();

/// Frames of fixed caps: how they lie in memory unless a buffer says otherwise.
struct FrameLayout {
  StreamFormat format;
  GstVideoInfo info;  ///< not of Bayer frames, which GstVideoInfo lacks
  bool is_bayer = false;
  size_t num_bytes = 0;
};

/// Nothing if the runtime has not the format, or not in that size.
std::optional<FrameLayout> LayoutOf(const GstCaps* caps);

/// A table of a blob: sizes of the frames that it takes and makes.
struct TableSizes {
  uint16_t frame_width, frame_height, view_width, view_height;

  bool operator==(const TableSizes& other) const {
    return frame_width == other.frame_width &&
           frame_height == other.frame_height &&
           view_width == other.view_width && view_height == other.view_height;
  }
};

/// Caps on the other side of tables: of the frames that they make for
/// GST_PAD_SINK, of those that they take for GST_PAD_SRC. The first table's
/// come first. To be unreferenced.
GstCaps* OtherSide(GstPadDirection direction, const GstCaps* caps,
                   const std::vector<TableSizes>& tables);

/// Caps with any size instead of theirs. To be unreferenced.
GstCaps* OfAnySize(const GstCaps* caps);

}  // namespace raygrid

#endif  // RAYGRID_GSTREAMER_CAPS_H
