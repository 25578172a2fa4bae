// The element raygridundistort by GstHarness: its frames are those of
// rg_remap().
#include <gst/check/gstharness.h>
#include <gst/video/video.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include "blob_edit.h"
#include "golden_blobs.h"
#include "raygrid.h"
#include "stream_format.h"

namespace raygrid {
namespace {

// A file that goes with the test.
class TemporaryFile {
 public:
  TemporaryFile(const void* bytes, size_t size) {
    const int file = mkstemp(path_);
    EXPECT_EQ(write(file, bytes, size), static_cast<ssize_t>(size));
    close(file);
  }
  ~TemporaryFile() { unlink(path_); }
  const char* path() const { return path_; }

 private:
  char path_[32] = "/tmp/raygrid-blob-XXXXXX";
};

constexpr int kWidth = 160, kHeight = 120;  // of the golden lens

rg_camera OpenLens() {
  rg_camera camera;
  if (rg_camera_open(&camera, kLensBlob, sizeof(kLensBlob)) != RG_OK ||
      rg_select_remap(&camera, 0) != RG_OK)
    abort();
  return camera;
}

std::vector<PixelFormatInfo> FormatsOfGstreamer() {
  std::vector<PixelFormatInfo> formats = PixelFormats();
  const auto has_no_name = [](const PixelFormatInfo& f) {
    return !f.gstreamer;
  };
  formats.erase(std::remove_if(formats.begin(), formats.end(), has_no_name),
                formats.end());
  return formats;
}

bool IsBayer(const PixelFormatInfo& format) {
  return format.model == ColourModel::kBayer;
}

const char* MediaOf(const PixelFormatInfo& format) {
  return IsBayer(format) ? "video/x-bayer" : "video/x-raw";
}

// The first error on a bus; empty: none.
std::string FirstError(GstBus* bus) {
  GstMessage* const message = gst_bus_pop_filtered(bus, GST_MESSAGE_ERROR);
  if (!message) return "";
  GError* error = nullptr;
  gst_message_parse_error(message, &error, nullptr);
  const std::string text = error->message;
  g_error_free(error);
  gst_message_unref(message);
  return text;
}

// A harness around the element, playing with a blob.
class Pipeline {
 public:
  explicit Pipeline(const char* blob, const char* properties = "")
      : element_(gst_parse_launch(
            (std::string("raygridundistort blob=") + blob + " " + properties)
                .c_str(),
            nullptr)),
        bus_(gst_bus_new()) {
    gst_element_set_bus(element_, bus_);
    harness_ = gst_harness_new_with_element(element_, "sink", "src");
  }
  ~Pipeline() {
    gst_harness_teardown(harness_);
    gst_element_set_bus(element_, nullptr);
    gst_object_unref(element_);
    gst_object_unref(bus_);
  }

  GstHarness* get() const { return harness_; }
  template <typename Value>
  void Set(const char* property, Value value) const {
    g_object_set(element_, property, value, nullptr);
  }
  // By the text of the value, as gst_parse_launch() takes it.
  void SetText(const char* property, const char* value) const {
    gst_util_set_object_arg(G_OBJECT(element_), property, value);
  }
  // The first error that was posted; empty: none.
  std::string TakeError() const { return FirstError(bus_); }
  void SetCaps(const char* media, const char* format, int width, int height,
               const char* colorimetry = nullptr) const {
    GstCaps* const caps =
        gst_caps_new_simple(media, "format", G_TYPE_STRING, format, "width",
                            G_TYPE_INT, width, "height", G_TYPE_INT, height,
                            "framerate", GST_TYPE_FRACTION, 30, 1, nullptr);
    if (colorimetry)
      gst_caps_set_simple(caps, "colorimetry", G_TYPE_STRING, colorimetry,
                          nullptr);
    gst_harness_set_src_caps(harness_, caps);
  }

 private:
  GstElement* const element_;
  GstBus* const bus_;
  GstHarness* harness_;
};

std::vector<uint8_t> Noise(size_t size) {
  std::vector<uint8_t> bytes(size);
  uint32_t state = 1;
  for (uint8_t& byte : bytes) {
    state = state * 1664525u + 1013904223u;
    byte = static_cast<uint8_t>(state >> 24);
  }
  return bytes;
}

// A frame in memory: where each plane begins, and its stride.
struct Memory {
  size_t offsets[3] = {};
  uint32_t strides[3] = {};
  size_t size = 0;
};

// Lays out planes with `gap` bytes of padding before each plane and 2 * gap
// after each row.
Memory LayOut(const StreamFormat& format, uint32_t gap) {
  Memory memory;
  for (int i = 0; i < format.num_planes; ++i) {
    memory.offsets[i] = memory.size + gap;
    memory.strides[i] = format.planes[i].row_bytes + 2 * gap;
    memory.size =
        memory.offsets[i] + size_t{memory.strides[i]} * format.planes[i].rows;
  }
  return memory;
}

// Rows of a Bayer buffer begin at multiples of 4 bytes.
Memory LayOutBayer(const StreamFormat& format) {
  Memory memory;
  memory.strides[0] = (format.planes[0].row_bytes + 3) / 4 * 4;
  memory.size = size_t{memory.strides[0]} * format.planes[0].rows;
  return memory;
}

std::vector<uint8_t> RowsOf(const StreamFormat& format, const Memory& memory,
                            const uint8_t* bytes) {
  std::vector<uint8_t> rows;
  for (int i = 0; i < format.num_planes; ++i)
    for (uint32_t row = 0; row < format.planes[i].rows; ++row) {
      const uint8_t* const begin =
          bytes + memory.offsets[i] + size_t{memory.strides[i]} * row;
      rows.insert(rows.end(), begin, begin + format.planes[i].row_bytes);
    }
  return rows;
}

// Rows without gaps of the frame that rg_remap() makes of one in memory.
std::vector<uint8_t> Remapped(const StreamFormat& frames,
                              const StreamFormat& views, const Memory& memory,
                              const uint8_t* bytes) {
  const rg_camera camera = OpenLens();
  const uint8_t* planes[3];
  for (int i = 0; i < 3; ++i) planes[i] = bytes + memory.offsets[i];
  rg_image image = MakeImage(frames, planes);
  std::vector<uint8_t> made(views.packed_size());
  rg_target target = {};
  target.num_rows = views.height;
  SetBlackBorder(views, &target);
  uint8_t* next = made.data();
  for (int i = 0; i < frames.num_planes; ++i) {
    image.planes[i].stride = memory.strides[i];
    target.planes[i].data = next;
    target.planes[i].stride = views.planes[i].row_bytes;
    next += size_t{views.planes[i].row_bytes} * views.planes[i].rows;
  }
  EXPECT_EQ(rg_remap(&camera, &image, &target), RG_OK);
  return made;
}

StreamFormat FormatOfViews(const PixelFormatInfo& pixel_format) {
  const rg_camera camera = OpenLens();
  uint16_t width, height;
  rg_remap_size(&camera, &width, &height);
  return MakeStreamFormat(pixel_format, width, height, 0);
}

// A buffer of the bytes; says how its planes lie where caps do not.
GstBuffer* BufferOf(const PixelFormatInfo& pixel_format, const Memory& memory,
                    const std::vector<uint8_t>& bytes, int num_planes) {
  GstBuffer* const buffer = gst_buffer_new_memdup(bytes.data(), bytes.size());
  if (IsBayer(pixel_format)) return buffer;
  gsize offsets[GST_VIDEO_MAX_PLANES] = {};
  gint strides[GST_VIDEO_MAX_PLANES] = {};
  for (int i = 0; i < num_planes; ++i) {
    offsets[i] = memory.offsets[i];
    strides[i] = static_cast<gint>(memory.strides[i]);
  }
  gst_buffer_add_video_meta_full(
      buffer, GST_VIDEO_FRAME_FLAG_NONE,
      gst_video_format_from_string(pixel_format.gstreamer), kWidth, kHeight,
      static_cast<guint>(num_planes), offsets, strides);
  return buffer;
}

// Rows without gaps of a buffer that the element made.
std::vector<uint8_t> RowsOfBuffer(const Pipeline& pipeline,
                                  const StreamFormat& format, bool is_bayer,
                                  GstBuffer* buffer) {
  if (is_bayer) {
    GstMapInfo map;
    EXPECT_TRUE(gst_buffer_map(buffer, &map, GST_MAP_READ));
    const auto rows = RowsOf(format, LayOutBayer(format), map.data);
    gst_buffer_unmap(buffer, &map);
    return rows;
  }
  GstCaps* const caps = gst_pad_get_current_caps(pipeline.get()->sinkpad);
  GstVideoInfo info;
  EXPECT_TRUE(gst_video_info_from_caps(&info, caps));
  gst_caps_unref(caps);
  EXPECT_EQ(GST_VIDEO_INFO_WIDTH(&info), format.width);
  EXPECT_EQ(GST_VIDEO_INFO_HEIGHT(&info), format.height);
  GstVideoFrame frame;
  EXPECT_TRUE(gst_video_frame_map(&frame, &info, buffer, GST_MAP_READ));
  std::vector<uint8_t> rows;
  for (int i = 0; i < format.num_planes; ++i) {
    Memory plane;
    plane.strides[0] =
        static_cast<uint32_t>(GST_VIDEO_FRAME_PLANE_STRIDE(&frame, i));
    StreamFormat one = format;
    one.num_planes = 1;
    one.planes[0] = format.planes[i];
    const auto more = RowsOf(
        one, plane,
        static_cast<const uint8_t*>(GST_VIDEO_FRAME_PLANE_DATA(&frame, i)));
    rows.insert(rows.end(), more.begin(), more.end());
  }
  gst_video_frame_unmap(&frame);
  return rows;
}

// The pipeline takes a frame of that format, and gives it as rg_remap() does.
void CheckFrame(const Pipeline& pipeline, const PixelFormatInfo& pixel_format,
                uint32_t gap, const char* colorimetry = nullptr,
                bool is_full_range = false) {
  const bool is_bayer = IsBayer(pixel_format);
  pipeline.SetCaps(MediaOf(pixel_format), pixel_format.gstreamer, kWidth,
                   kHeight, colorimetry);
  const StreamFormat frames =
      MakeStreamFormat(pixel_format, kWidth, kHeight, 0);
  StreamFormat views = FormatOfViews(pixel_format);
  views.is_full_range = is_full_range;
  const Memory memory = is_bayer ? LayOutBayer(frames) : LayOut(frames, gap);
  const std::vector<uint8_t> bytes = Noise(memory.size);
  GstBuffer* const view = gst_harness_push_and_pull(
      pipeline.get(), BufferOf(pixel_format, memory, bytes, frames.num_planes));
  ASSERT_TRUE(view);
  EXPECT_EQ(RowsOfBuffer(pipeline, views, is_bayer, view),
            Remapped(frames, views, memory, bytes.data()));
  gst_buffer_unref(view);
}

GstBuffer* GreyFrame() {
  const std::vector<uint8_t> bytes = Noise(kWidth * kHeight);
  return gst_buffer_new_memdup(bytes.data(), bytes.size());
}

void CheckFormat(const PixelFormatInfo& pixel_format, uint32_t gap,
                 const char* properties) {
  SCOPED_TRACE(std::string(pixel_format.gstreamer) + " " + properties);
  const TemporaryFile blob(kLensBlob, sizeof(kLensBlob));
  CheckFrame(Pipeline(blob.path(), properties), pixel_format, gap);
}

TEST(UndistortElement, GivesTheBytesOfRemapInEveryFormat) {
  for (const PixelFormatInfo& pixel_format : FormatsOfGstreamer())
    CheckFormat(pixel_format, 0, "");
}

// Black is Y = 0 in what jpegdec gives: 1:4:0:0.
TEST(UndistortElement, HasABlackBorderInEveryRange) {
  const TemporaryFile blob(kLensBlob, sizeof(kLensBlob));
  for (const PixelFormatInfo& pixel_format : FormatsOfGstreamer())
    for (const auto& [colorimetry, is_full] :
         std::vector<std::pair<const char*, bool>>{{"1:4:0:0", true},
                                                   {"1:3:5:1", true},
                                                   {"2:4:0:0", false},
                                                   {"bt709", false}}) {
      if (IsBayer(pixel_format)) continue;
      SCOPED_TRACE(std::string(pixel_format.gstreamer) + " " + colorimetry);
      CheckFrame(Pipeline(blob.path()), pixel_format, 0, colorimetry, is_full);
    }
}

TEST(UndistortElement, TakesRowsAndPlanesWithGaps) {
  for (const PixelFormatInfo& pixel_format : FormatsOfGstreamer())
    CheckFormat(pixel_format, 12, "");
}

// A crop that begins at any pixel has such rows.
TEST(UndistortElement, TakesRowsAtOddAddresses) {
  for (const PixelFormatInfo& pixel_format : FormatsOfGstreamer())
    if (FindChannel(pixel_format.format, 0).component.kind == RG_SAMPLE_8)
      CheckFormat(pixel_format, 3, "");
}

TEST(UndistortElement, FormatsChangeWhileItPlays) {
  const TemporaryFile blob(kLensBlob, sizeof(kLensBlob));
  const Pipeline pipeline(blob.path());
  for (const int round : {0, 1})
    for (const PixelFormatInfo& pixel_format : FormatsOfGstreamer()) {
      SCOPED_TRACE(std::string(pixel_format.gstreamer) + std::to_string(round));
      CheckFrame(pipeline, pixel_format, 0);
    }
}

TEST(UndistortElement, DropsFramesThatWouldComeTooLate) {
  const TemporaryFile blob(kLensBlob, sizeof(kLensBlob));
  const Pipeline pipeline(blob.path());
  pipeline.SetCaps("video/x-raw", "GRAY8", kWidth, kHeight);
  GstHarness* const harness = pipeline.get();
  const auto push = [harness](GstClockTime time) {
    GstBuffer* const frame = GreyFrame();
    GST_BUFFER_PTS(frame) = time;
    GST_BUFFER_DURATION(frame) = GST_SECOND / 30;
    EXPECT_EQ(gst_harness_push(harness, frame), GST_FLOW_OK);
    return gst_harness_buffers_received(harness);
  };
  EXPECT_EQ(push(0), 1u);
  // The frame at 0 s was shown a second late.
  gst_harness_push_upstream_event(
      harness, gst_event_new_qos(GST_QOS_TYPE_UNDERFLOW, 2, GST_SECOND, 0));
  EXPECT_EQ(push(GST_SECOND / 30), 1u);
  EXPECT_EQ(push(GST_SECOND), 1u);
  EXPECT_EQ(push(4 * GST_SECOND), 2u);
}

TEST(UndistortElement, ThreadsGiveTheSameBytes) {
  for (const PixelFormatInfo& pixel_format : FormatsOfGstreamer())
    CheckFormat(pixel_format, 4, "threads=3");
}

TEST(UndistortElement, PassesFramesThroughWhileItIsDisabled) {
  const TemporaryFile blob(kLensBlob, sizeof(kLensBlob));
  const Pipeline pipeline(blob.path(), "enabled=false");
  pipeline.SetCaps("video/x-raw", "GRAY8", kWidth, kHeight);
  GstBuffer* const frame = GreyFrame();
  GstBuffer* view = gst_harness_push_and_pull(pipeline.get(), frame);
  EXPECT_EQ(view, frame);  // not even a copy
  gst_buffer_unref(view);
  for (const bool is_enabled : {true, false, true}) {
    pipeline.Set("enabled", is_enabled ? TRUE : FALSE);
    GstBuffer* const next = GreyFrame();
    view = gst_harness_push_and_pull(pipeline.get(), next);
    ASSERT_TRUE(view);
    EXPECT_EQ(view != next, is_enabled);
    gst_buffer_unref(view);
  }
}

TEST(UndistortElement, TakesAnotherBlobWhileItPlays) {
  const TemporaryFile blob(kLensBlob, sizeof(kLensBlob));
  const TemporaryFile other(kLensBlob, sizeof(kLensBlob));
  const Pipeline pipeline(blob.path());
  pipeline.SetCaps("video/x-raw", "GRAY8", kWidth, kHeight);
  for (int k = 0; k < 20; ++k) {
    pipeline.Set("blob", k % 2 == 0 ? other.path() : blob.path());
    pipeline.Set("threads", 1 + k % 3);
    pipeline.Set("border", k % 2);
    GstBuffer* const view =
        gst_harness_push_and_pull(pipeline.get(), GreyFrame());
    ASSERT_TRUE(view);
    gst_buffer_unref(view);
  }
}

// ---- Memory that elements before are offered -------------------------------

struct PoolUnref {
  void operator()(GstBufferPool* pool) const {
    gst_buffer_pool_set_active(pool, FALSE);
    gst_object_unref(pool);
  }
};
using Pool = std::unique_ptr<GstBufferPool, PoolUnref>;

// The pool that the element offers, set up as an element before it does, which
// keeps what is set up already, and knows GstVideoMeta or not; null for none.
Pool OfferedPool(const Pipeline& pipeline, bool knows_meta) {
  GstHarness* const harness = pipeline.get();
  GstCaps* const caps = gst_pad_get_current_caps(harness->srcpad);
  GstQuery* const query = gst_query_new_allocation(caps, TRUE);
  EXPECT_TRUE(gst_pad_peer_query(harness->srcpad, query));
  GstBufferPool* pool = nullptr;
  guint size = 0, least = 0, most = 0;
  if (gst_query_get_n_allocation_pools(query) > 0)
    gst_query_parse_nth_allocation_pool(query, 0, &pool, &size, &least, &most);
  if (pool) {
    GstStructure* const config = gst_buffer_pool_get_config(pool);
    gst_buffer_pool_config_set_params(config, caps, size, least, most);
    if (knows_meta)
      gst_buffer_pool_config_add_option(config,
                                        GST_BUFFER_POOL_OPTION_VIDEO_META);
    EXPECT_TRUE(gst_buffer_pool_set_config(pool, config));
    EXPECT_TRUE(gst_buffer_pool_set_active(pool, TRUE));
  }
  gst_query_unref(query);
  gst_caps_unref(caps);
  return Pool(pool);
}

// Rows and planes as caps alone say.
Memory LayOutAsCaps(const Pipeline& pipeline, const StreamFormat& format) {
  GstCaps* const caps = gst_pad_get_current_caps(pipeline.get()->srcpad);
  GstVideoInfo info;
  EXPECT_TRUE(gst_video_info_from_caps(&info, caps));
  gst_caps_unref(caps);
  Memory memory;
  for (int i = 0; i < format.num_planes; ++i) {
    memory.offsets[i] = GST_VIDEO_INFO_PLANE_OFFSET(&info, i);
    memory.strides[i] =
        static_cast<uint32_t>(GST_VIDEO_INFO_PLANE_STRIDE(&info, i));
  }
  memory.size = GST_VIDEO_INFO_SIZE(&info);
  return memory;
}

// A buffer of a pool says where its planes are.
Memory LayOutAsMeta(const StreamFormat& format, GstBuffer* buffer) {
  const GstVideoMeta* const meta = gst_buffer_get_video_meta(buffer);
  Memory memory;
  if (!meta) return memory;
  for (int i = 0; i < format.num_planes; ++i) {
    memory.offsets[i] = meta->offset[i];
    memory.strides[i] = static_cast<uint32_t>(meta->stride[i]);
    EXPECT_EQ(memory.strides[i] % 64, 0u);
  }
  memory.size = gst_buffer_get_size(buffer);
  return memory;
}

// An element before fills a buffer of the pool that it is offered, or of its
// own where there is none.
void CheckOfferedPool(const PixelFormatInfo& pixel_format, bool knows_meta) {
  SCOPED_TRACE(std::string(pixel_format.gstreamer) +
               (knows_meta ? " with meta" : ""));
  const bool is_bayer = IsBayer(pixel_format);
  const TemporaryFile blob(kLensBlob, sizeof(kLensBlob));
  const Pipeline pipeline(blob.path());
  pipeline.SetCaps(MediaOf(pixel_format), pixel_format.gstreamer, kWidth,
                   kHeight);
  const StreamFormat frames =
      MakeStreamFormat(pixel_format, kWidth, kHeight, 0);
  const StreamFormat views = FormatOfViews(pixel_format);
  Memory memory =
      is_bayer ? LayOutBayer(frames) : LayOutAsCaps(pipeline, frames);
  const Pool pool = OfferedPool(pipeline, knows_meta);
  GstBuffer* buffer = nullptr;
  if (pool)
    ASSERT_EQ(gst_buffer_pool_acquire_buffer(pool.get(), &buffer, nullptr),
              GST_FLOW_OK);
  else
    buffer = gst_buffer_new_allocate(nullptr, memory.size, nullptr);
  if (pool && knows_meta) memory = LayOutAsMeta(frames, buffer);
  const std::vector<uint8_t> bytes = Noise(memory.size);
  ASSERT_EQ(gst_buffer_fill(buffer, 0, bytes.data(), bytes.size()),
            bytes.size());
  GstBuffer* const view = gst_harness_push_and_pull(pipeline.get(), buffer);
  ASSERT_TRUE(view);
  EXPECT_EQ(RowsOfBuffer(pipeline, views, is_bayer, view),
            Remapped(frames, views, memory, bytes.data()));
  gst_buffer_unref(view);
}

TEST(UndistortElement, OffersBuffersThatHoldAFrame) {
  for (const PixelFormatInfo& pixel_format : FormatsOfGstreamer())
    for (const bool knows_meta : {false, true})
      CheckOfferedPool(pixel_format, knows_meta);
}

// ---- Settings while it plays -----------------------------------------------

constexpr int kWideWidth = 320, kWideHeight = 240;

// A frame of a wide lens as the pipeline makes it.
std::vector<uint8_t> MadeOf(const Pipeline& pipeline,
                            const std::vector<uint8_t>& bytes) {
  if (gst_harness_push(pipeline.get(),
                       gst_buffer_new_memdup(bytes.data(), bytes.size())) !=
      GST_FLOW_OK) {
    ADD_FAILURE() << pipeline.TakeError();
    return {};
  }
  GstBuffer* const view = gst_harness_try_pull(pipeline.get());
  if (!view) return {};
  std::vector<uint8_t> made(gst_buffer_get_size(view));
  gst_buffer_extract(view, 0, made.data(), made.size());
  gst_buffer_unref(view);
  return made;
}

// Blobs for the same frames, and one whose table 3 makes views of their size.
class WideBlobs {
 public:
  std::vector<std::string> paths() const {
    return {wide_.path(), bent_.path(), stack_.path(), views_.path()};
  }
  const char* same_size() const { return distorting_.path(); }

 private:
  static std::vector<uint8_t> WithSameSize() {
    std::vector<uint8_t> bytes(
        reinterpret_cast<const uint8_t*>(kModesBlob),
        reinterpret_cast<const uint8_t*>(kModesBlob) + sizeof(kModesBlob));
    const uint8_t* const section =
        rg_find_section(bytes.data(), RG_SECTION_REMAP, 3);
    uint8_t* const source =
        bytes.data() + (section - bytes.data()) + RG_VIEW_SOURCE_WIDTH;
    const uint16_t size[2] = {kWideWidth, kWideHeight};
    for (int c = 0; c < 2; ++c) {
      source[2 * c] = static_cast<uint8_t>(size[c]);
      source[2 * c + 1] = static_cast<uint8_t>(size[c] >> 8);
    }
    repair_crcs(bytes.data(), static_cast<uint32_t>(bytes.size()));
    return bytes;
  }

  std::vector<uint8_t> same_size_ = WithSameSize();
  const TemporaryFile wide_{kWideBlob, sizeof(kWideBlob)},
      bent_{kBentBlob, sizeof(kBentBlob)},
      stack_{kStackBlob, sizeof(kStackBlob)},
      views_{kViewsBlob, sizeof(kViewsBlob)},
      distorting_{same_size_.data(), same_size_.size()};
};

// The properties and some of their values.
using Choices = std::vector<std::pair<std::string, std::vector<std::string>>>;

// Sets properties at random; each frame is that of an element that was started
// with them. Returns how many different ones came.
size_t CountFramesOfRandomSettings(const char* blob, const Choices& choices,
                                   int num_frames) {
  const std::vector<uint8_t> bytes = Noise(kWideWidth * kWideHeight);
  const auto start = [](const Pipeline& pipeline) {
    pipeline.SetCaps("video/x-raw", "GRAY8", kWideWidth, kWideHeight);
  };
  std::map<std::string, std::string> settings = {{"blob", blob}};
  std::set<std::vector<uint8_t>> frames;
  const Pipeline live(blob);
  start(live);
  uint32_t state = 1;
  const auto below = [&state](size_t limit) {
    state = state * 1664525u + 1013904223u;
    return (state >> 8) % limit;
  };
  for (int k = 0; k < num_frames; ++k) {
    const auto& [name, values] = choices[below(choices.size())];
    settings[name] = values[below(values.size())];
    live.SetText(name.c_str(), settings[name].c_str());
    std::string properties;
    for (const auto& [property, value] : settings)
      if (property != "blob") properties += " " + property + "=" + value;
    SCOPED_TRACE(name + " of" + properties);
    const Pipeline fresh(settings["blob"].c_str(), properties.c_str());
    start(fresh);
    const std::vector<uint8_t> made = MadeOf(live, bytes);
    EXPECT_FALSE(made.empty());
    EXPECT_EQ(made, MadeOf(fresh, bytes));
    frames.insert(made);
  }
  return frames.size();
}

TEST(UndistortElement, TakesEverySettingWithTheNextFrame) {
  const WideBlobs blobs;
  const Choices choices = {{"blob", blobs.paths()},
                           {"table", {"-1", "0", "1"}},
                           {"border", {"black", "clamp"}},
                           {"sampling", {"bilinear", "nearest"}},
                           {"outside", {"fill", "border", "trusted"}},
                           {"threads", {"1", "2"}},
                           {"enabled", {"true", "true", "false"}}};
  EXPECT_GT(CountFramesOfRandomSettings(blobs.paths()[0].c_str(), choices, 200),
            20u);
}

// Caps are the same then, with all settings.
TEST(UndistortElement, TakesSettingsWhereViewsAreAsLargeAsFrames) {
  const WideBlobs blobs;
  const Choices choices = {{"enabled", {"true", "false"}},
                           {"border", {"black", "clamp"}},
                           {"sampling", {"bilinear", "nearest"}}};
  EXPECT_GT(CountFramesOfRandomSettings(blobs.same_size(), choices, 40), 3u);
}

TEST(UndistortElement, FailsAtASettingThatCannotBe) {
  const WideBlobs blobs;
  const std::vector<uint8_t> bytes = Noise(kWideWidth * kWideHeight);
  for (const auto& [property, value, words] :
       std::vector<std::array<const char*, 3>>{
           {"table", "7",
            "has no remap table 7, only 0 to 1; use one of these"},
           {"blob", "/nowhere/lens.raygrid", "cannot be read"},
           {"blob", "", "set blob="},
           {"blob", blobs.same_size(), "its remap tables undistort"}}) {
    SCOPED_TRACE(value);
    const Pipeline pipeline(blobs.paths()[0].c_str());
    pipeline.SetCaps("video/x-raw", "GRAY8", kWideWidth, kWideHeight);
    EXPECT_FALSE(MadeOf(pipeline, bytes).empty());
    pipeline.SetText(property, value);
    if (std::strcmp(words, "its remap tables undistort") == 0)
      pipeline.SetCaps("video/x-raw", "GRAY8", kWideWidth / 2, kWideHeight);
    EXPECT_LT(gst_harness_push(pipeline.get(), gst_buffer_new_memdup(
                                                   bytes.data(), bytes.size())),
              GST_FLOW_OK);
    const std::string error = pipeline.TakeError();
    EXPECT_NE(error.find(words), std::string::npos) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
}

TEST(UndistortElement, SaysWhatATableIsFor) {
  const TemporaryFile blob(kModesBlob, sizeof(kModesBlob));
  for (const auto& [properties, words] :
       std::vector<std::array<const char*, 2>>{
           {"table=1",
            "table 1 undistorts 160x120 to 48x32, but frames are 120x100; omit "
            "table"},
           {"",
            "its remap tables undistort 120x100 to 40x30, 160x120 to 48x32"}}) {
    const Pipeline pipeline(blob.path(), properties);
    const int width = std::strlen(properties) > 0 ? 120 : 640;
    pipeline.SetCaps("video/x-raw", "GRAY8", width, 100);
    EXPECT_EQ(gst_harness_push(pipeline.get(), GreyFrame()),
              GST_FLOW_NOT_NEGOTIATED);
    const std::string error = pipeline.TakeError();
    EXPECT_NE(error.find(words), std::string::npos) << error;
  }
}

// A frame of the golden stack's camera, as its first table makes of it.
std::vector<uint8_t> RemappedAt(std::optional<int32_t> value_q16,
                                const std::vector<uint8_t>& bytes) {
  rg_camera camera;
  EXPECT_EQ(rg_camera_open(&camera, kStackBlob, sizeof(kStackBlob)), RG_OK);
  EXPECT_EQ(rg_select_remap(&camera, 0), RG_OK);
  if (value_q16) {
    EXPECT_EQ(rg_set_operating_point(&camera, *value_q16), RG_OK);
  }
  uint16_t frame_width, frame_height, width, height;
  rg_frame_size(&camera, &frame_width, &frame_height);
  rg_remap_size(&camera, &width, &height);
  std::vector<uint8_t> view(size_t{width} * height);
  const rg_grey_image frame = {bytes.data(), frame_width, frame_width,
                               frame_height};
  const rg_grey_target band = {view.data(), width, 0, height, 0};
  EXPECT_EQ(rg_remap_grey(&camera, &frame, &band), RG_OK);
  return view;
}

TEST(UndistortElement, TakesAnotherLensPositionWithEachFrame) {
  constexpr int kFrameWidth = 320, kFrameHeight = 240;
  const TemporaryFile blob(kStackBlob, sizeof(kStackBlob));
  const Pipeline pipeline(blob.path(), "table=0");
  pipeline.SetCaps("video/x-raw", "GRAY8", kFrameWidth, kFrameHeight);
  const std::vector<uint8_t> bytes = Noise(kFrameWidth * kFrameHeight);
  const auto undistorted = [&] {
    GstBuffer* const view = gst_harness_push_and_pull(
        pipeline.get(), gst_buffer_new_memdup(bytes.data(), bytes.size()));
    std::vector<uint8_t> made(gst_buffer_get_size(view));
    gst_buffer_extract(view, 0, made.data(), made.size());
    gst_buffer_unref(view);
    return made;
  };
  EXPECT_EQ(undistorted(), RemappedAt(std::nullopt, bytes));
  for (const double dioptres : {0.25, 5.0, 5.0}) {
    pipeline.Set("condition", dioptres);
    EXPECT_EQ(undistorted(),
              RemappedAt(static_cast<int32_t>(dioptres * 65536), bytes));
  }
  EXPECT_NE(undistorted(), RemappedAt(std::nullopt, bytes));
}

TEST(UndistortElement, PassesTheEndAndTenThousandFrames) {
  const TemporaryFile blob(kLensBlob, sizeof(kLensBlob));
  const Pipeline pipeline(blob.path(), "threads=2");
  pipeline.SetCaps("video/x-raw", "GRAY8", kWidth, kHeight);
  GstBuffer* const frame = GreyFrame();
  for (int k = 0; k < 10000; ++k) {
    GstBuffer* const view =
        gst_harness_push_and_pull(pipeline.get(), gst_buffer_ref(frame));
    ASSERT_TRUE(view);
    gst_buffer_unref(view);
  }
  gst_buffer_unref(frame);
  ASSERT_TRUE(gst_harness_push_event(pipeline.get(), gst_event_new_eos()));
  bool has_ended = false;
  while (GstEvent* const event = gst_harness_try_pull_event(pipeline.get())) {
    has_ended = has_ended || GST_EVENT_TYPE(event) == GST_EVENT_EOS;
    gst_event_unref(event);
  }
  EXPECT_TRUE(has_ended);
}

// The error that an element posts when it is to start.
std::string ErrorOfStarting(const std::string& properties) {
  GstElement* const element =
      gst_parse_launch_full(("raygridundistort " + properties).c_str(), nullptr,
                            GST_PARSE_FLAG_NONE, nullptr);
  GstBus* const bus = gst_bus_new();
  gst_element_set_bus(element, bus);
  EXPECT_EQ(gst_element_set_state(element, GST_STATE_PAUSED),
            GST_STATE_CHANGE_FAILURE);
  const std::string text = FirstError(bus);
  gst_element_set_state(element, GST_STATE_NULL);
  gst_element_set_bus(element, nullptr);
  gst_object_unref(bus);
  gst_object_unref(element);
  return text;
}

TEST(UndistortElement, SaysWhatIsWrongWithABlob) {
  EXPECT_NE(ErrorOfStarting("").find("set blob="), std::string::npos);
  const std::string missing = ErrorOfStarting("blob=/nowhere/lens.raygrid");
  EXPECT_NE(missing.find("/nowhere/lens.raygrid: cannot be read"),
            std::string::npos)
      << missing;
  std::vector<uint8_t> damaged(
      reinterpret_cast<const uint8_t*>(kLensBlob),
      reinterpret_cast<const uint8_t*>(kLensBlob) + sizeof(kLensBlob));
  damaged[damaged.size() / 2] ^= 1;
  const TemporaryFile file(damaged.data(), damaged.size());
  const std::string corrupt =
      ErrorOfStarting(std::string("blob=") + file.path());
  EXPECT_EQ(corrupt.rfind(file.path(), 0), 0u) << corrupt;
  EXPECT_EQ(corrupt.find('\n'), std::string::npos) << corrupt;
}

TEST(UndistortElement, RefusesFramesThatNoTableIsFor) {
  const TemporaryFile blob(kLensBlob, sizeof(kLensBlob));
  const Pipeline pipeline(blob.path());
  pipeline.SetCaps("video/x-raw", "GRAY8", kWidth - 2, kHeight);
  EXPECT_EQ(gst_harness_push(pipeline.get(), GreyFrame()),
            GST_FLOW_NOT_NEGOTIATED);
}

TEST(UndistortElement, FailsAtABufferThatIsTooShort) {
  const TemporaryFile blob(kLensBlob, sizeof(kLensBlob));
  for (const char* media : {"video/x-raw", "video/x-bayer"}) {
    const Pipeline pipeline(blob.path());
    const bool is_raw = std::strcmp(media, "video/x-raw") == 0;
    pipeline.SetCaps(media, is_raw ? "GRAY8" : "rggb", kWidth, kHeight);
    EXPECT_EQ(gst_harness_push(pipeline.get(),
                               gst_buffer_new_allocate(nullptr, 100, nullptr)),
              GST_FLOW_ERROR);
  }
}

TEST(UndistortElement, MovesRegionsOfInterest) {
  const TemporaryFile blob(kLensBlob, sizeof(kLensBlob));
  const Pipeline pipeline(blob.path());
  pipeline.SetCaps("video/x-raw", "GRAY8", kWidth, kHeight);
  GstBuffer* const frame = GreyFrame();
  GstVideoRegionOfInterestMeta* const given =
      gst_buffer_add_video_region_of_interest_meta(frame, "face", 70, 50, 20,
                                                   16);
  given->id = 7;
  gst_video_region_of_interest_meta_add_param(
      given, gst_structure_new("score", "part", G_TYPE_DOUBLE, 0.5, nullptr));
  GstBuffer* const view = gst_harness_push_and_pull(pipeline.get(), frame);
  ASSERT_TRUE(view);
  const auto* const moved =
      gst_buffer_get_video_region_of_interest_meta_id(view, 7);
  ASSERT_TRUE(moved);
  EXPECT_STREQ(g_quark_to_string(moved->roi_type), "face");
  EXPECT_TRUE(gst_video_region_of_interest_meta_get_param(
      const_cast<GstVideoRegionOfInterestMeta*>(moved), "score"));
  const rg_camera camera = OpenLens();
  for (int y = 50; y < 66; ++y)
    for (int x = 70; x < 90; ++x) {
      const rg_pixel pixel = {RG_PIXEL(x), RG_PIXEL(y)};
      rg_pixel seen;
      ASSERT_EQ(rg_undistort_point(&camera, pixel, &seen), RG_OK);
      const double u = seen.x_q16 / 65536.0, v = seen.y_q16 / 65536.0;
      EXPECT_TRUE(u >= moved->x - 0.5 && u <= moved->x + moved->w - 0.5 &&
                  v >= moved->y - 0.5 && v <= moved->y + moved->h - 0.5)
          << x << ", " << y << " at " << u << ", " << v;
    }
  EXPECT_LT(moved->w * moved->h, 4 * 20 * 16);
  gst_buffer_unref(view);
}

// Its frames are the view's, which rg_undistort_point() does not lead from.
TEST(UndistortElement, DropsRegionsWithATableThatDistorts) {
  rg_camera camera;
  ASSERT_EQ(rg_camera_open(&camera, kModesBlob, sizeof(kModesBlob)), RG_OK);
  rg_view view = {};
  int table = -1;
  while (!view.distorts) {
    ASSERT_EQ(rg_select_remap(&camera, static_cast<uint32_t>(++table)), RG_OK);
    ASSERT_EQ(rg_remap_view(&camera, &view), RG_OK);
  }
  uint16_t width, height;
  rg_frame_size(&camera, &width, &height);
  const TemporaryFile blob(kModesBlob, sizeof(kModesBlob));
  const Pipeline pipeline(blob.path(),
                          ("table=" + std::to_string(table)).c_str());
  pipeline.SetCaps("video/x-raw", "GRAY8", width, height);
  const std::vector<uint8_t> bytes = Noise(size_t{width} * height);
  GstBuffer* const frame = gst_buffer_new_memdup(bytes.data(), bytes.size());
  gst_buffer_add_video_region_of_interest_meta(frame, "face", width / 2,
                                               height / 2, 8, 8);
  GstBuffer* const made = gst_harness_push_and_pull(pipeline.get(), frame);
  ASSERT_TRUE(made);
  EXPECT_FALSE(
      gst_buffer_get_meta(made, GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE));
  gst_buffer_unref(made);
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  gst_init(&argc, &argv);
  GError* error = nullptr;
  if (argc != 2 || !gst_plugin_load_file(argv[1], &error)) {
    std::fprintf(stderr, "undistort_element_test PLUGIN: %s\n",
                 error ? error->message : "one argument");
    return 1;
  }
  return RUN_ALL_TESTS();
}
