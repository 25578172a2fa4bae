#include "caps.h"

#include <cstring>
#include <initializer_list>
#include <string>

#include "camera_error.h"
#include "rg_blob.h"

namespace raygrid {
namespace {

// Elements negotiate the first format that they have in common.
void AppendCaps(const char* media, std::initializer_list<ColourModel> models,
                GstCaps* caps) {
  GValue list = G_VALUE_INIT, name = G_VALUE_INIT;
  g_value_init(&list, GST_TYPE_LIST);
  g_value_init(&name, G_TYPE_STRING);
  for (const ColourModel model : models)
    for (const PixelFormatInfo& format : PixelFormats()) {
      if (!format.gstreamer || format.model != model) continue;
      g_value_set_static_string(&name, format.gstreamer);
      gst_value_list_append_value(&list, &name);
    }
  GstStructure* const structure = gst_structure_new(
      media, "width", GST_TYPE_INT_RANGE, 1, RG_MAX_IMAGE_SIZE, "height",
      GST_TYPE_INT_RANGE, 1, RG_MAX_IMAGE_SIZE, "framerate",
      GST_TYPE_FRACTION_RANGE, 0, 1, G_MAXINT, 1, nullptr);
  gst_structure_set_value(structure, "format", &list);
  gst_caps_append_structure(caps, structure);
  g_value_unset(&name);
  g_value_unset(&list);
}

const PixelFormatInfo* FindByName(const char* gstreamer, bool is_bayer) {
  for (const PixelFormatInfo& format : PixelFormats())
    if (gstreamer && format.gstreamer &&
        std::strcmp(format.gstreamer, gstreamer) == 0 &&
        (format.model == ColourModel::kBayer) == is_bayer)
      return &format;
  return nullptr;
}

void SetSize(GstStructure* structure, int width, int height) {
  gst_structure_set(structure, "width", G_TYPE_INT, width, "height", G_TYPE_INT,
                    height, nullptr);
}

// Whether the sizes in a structure include this one.
bool HasSize(const GstStructure* structure, int width, int height) {
  GstStructure* const size =
      gst_structure_new("size", "width", G_TYPE_INT, width, "height",
                        G_TYPE_INT, height, nullptr);
  bool has = true;
  for (const char* name : {"width", "height"}) {
    const GValue* const value = gst_structure_get_value(structure, name);
    // gst_value_can_intersect() compares only types.
    has = has &&
          (!value || gst_value_intersect(nullptr, value,
                                         gst_structure_get_value(size, name)));
  }
  gst_structure_free(size);
  return has;
}

// Pixels of a view are square; those of its source may have any shape.
void SetPixelShape(GstPadDirection direction, GstStructure* structure) {
  if (direction == GST_PAD_SRC)
    gst_structure_remove_field(structure, "pixel-aspect-ratio");
  else if (gst_structure_has_name(structure, "video/x-raw"))
    gst_structure_set(structure, "pixel-aspect-ratio", GST_TYPE_FRACTION, 1, 1,
                      nullptr);
}

}  // namespace

GstCaps* TemplateCaps() {
  GstCaps* const caps = gst_caps_new_empty();
  AppendCaps("video/x-raw",
             {ColourModel::kGrey, ColourModel::kYuv, ColourModel::kRgb}, caps);
  AppendCaps("video/x-bayer", {ColourModel::kBayer}, caps);
  return caps;
}

std::optional<FrameLayout> ParseLayout(const GstCaps* caps) {
  const GstStructure* const structure = gst_caps_get_structure(caps, 0);
  const char* const name = gst_structure_get_string(structure, "format");
  int width = 0, height = 0;
  if (!gst_structure_get_int(structure, "width", &width) ||
      !gst_structure_get_int(structure, "height", &height) || width < 1 ||
      height < 1)
    return std::nullopt;
  FrameLayout layout;
  layout.is_bayer = gst_structure_has_name(structure, "video/x-bayer");
  const PixelFormatInfo* const format = FindByName(name, layout.is_bayer);
  if (!format) return std::nullopt;
  // Rows of Bayer frames are aligned to 4 bytes.
  const uint32_t stride = layout.is_bayer ? GST_ROUND_UP_4(width) : 0;
  try {
    layout.format = MakeStreamFormat(*format, static_cast<uint32_t>(width),
                                     static_cast<uint32_t>(height), stride);
  } catch (const CameraError&) {
    return std::nullopt;
  }
  if (layout.is_bayer) {
    layout.num_bytes = size_t{stride} * static_cast<uint32_t>(height);
    return layout;
  }
  if (!gst_video_info_from_caps(&layout.info, caps)) return std::nullopt;
  layout.num_bytes = layout.info.size;
  layout.format.is_full_range =
      layout.info.colorimetry.range == GST_VIDEO_COLOR_RANGE_0_255;
  return layout;
}

GstCaps* ConvertCaps(GstPadDirection direction, const GstCaps* caps,
                     const std::vector<TableSizes>& tables) {
  GstCaps* const others = gst_caps_new_empty();
  for (guint k = 0; k < gst_caps_get_size(caps); ++k) {
    const GstStructure* const given = gst_caps_get_structure(caps, k);
    for (const TableSizes& table : tables) {
      const bool makes = direction == GST_PAD_SRC;
      const int from[2] = {makes ? table.view_width : table.frame_width,
                           makes ? table.view_height : table.frame_height};
      const int to[2] = {makes ? table.frame_width : table.view_width,
                         makes ? table.frame_height : table.view_height};
      if (!HasSize(given, from[0], from[1])) continue;
      GstStructure* const other = gst_structure_copy(given);
      SetSize(other, to[0], to[1]);
      SetPixelShape(direction, other);
      gst_caps_append_structure(others, other);
    }
  }
  return others;
}

GstCaps* MakeAnySizeCaps(const GstCaps* caps) {
  GstCaps* const others = gst_caps_copy(caps);
  for (guint k = 0; k < gst_caps_get_size(others); ++k) {
    GstStructure* const other = gst_caps_get_structure(others, k);
    gst_structure_set(other, "width", GST_TYPE_INT_RANGE, 1, RG_MAX_IMAGE_SIZE,
                      "height", GST_TYPE_INT_RANGE, 1, RG_MAX_IMAGE_SIZE,
                      nullptr);
    gst_structure_remove_field(other, "pixel-aspect-ratio");
  }
  return others;
}

}  // namespace raygrid
