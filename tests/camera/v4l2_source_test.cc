#include "v4l2_source.h"

#include <gtest/gtest.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <tuple>

#include "camera_error.h"
#include "fake_v4l2_source.h"
#include "jpeg_encoder.h"
#include "jpeg_reader.h"
#include "v4l2_controls.h"
#include "v4l2_formats.h"
#include "v4l2_list.h"

namespace raygrid {
namespace {

void ExpectRefused(FakeV4l2State* state, const V4l2Options& options,
                   const std::string& word) {
  try {
    Open(state, options)->Start();
    FAIL() << word;
  } catch (const CameraError& error) {
    EXPECT_EQ(error.code(), CameraExit::kInput);
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("/dev/fake: "), std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("; "), std::string::npos)
        << error.what();
  }
  EXPECT_EQ(state->num_mapped, 0);
  EXPECT_TRUE(state->dma_bufs.empty());
}

TEST(V4l2Source, FramesComeInOrderWithTheirNumbers) {
  FakeV4l2State state;
  MakeGrey(&state);
  state.events = {Frame(7, 10), Frame(8, 11), Frame(9, 14)};
  const auto source = Open(&state);
  EXPECT_EQ(source->format().planes[0].stride, kStride);
  EXPECT_EQ(source->memory(), "the driver's");
  source->Start();
  const auto frame = source->Next(kSoon);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->image.planes[0].data[0], 7);
  EXPECT_EQ(frame->info.sequence, 10u);
  EXPECT_EQ(frame->info.timestamp_ns, 1000010000u);
  source->Release(*frame);
  EXPECT_EQ(NextValue(source.get()), 8);
  EXPECT_EQ(NextValue(source.get()), 9);
  EXPECT_EQ(source->counts().missed, 2u);
  EXPECT_EQ(source->counts().arrived, 3u);
  source->Stop();
  EXPECT_TRUE(source->is_finished());
  EXPECT_EQ(source->fault(), "");
  EXPECT_FALSE(state.is_streaming);
}

TEST(V4l2Source, ARangeIsTheDrivers) {
  for (const bool are_apart : {false, true})
    for (const auto& [colour_space, quantization, is_full] :
         std::vector<std::tuple<uint32_t, uint32_t, bool>>{
             {V4L2_COLORSPACE_SRGB, V4L2_QUANTIZATION_DEFAULT, false},
             {V4L2_COLORSPACE_SRGB, V4L2_QUANTIZATION_FULL_RANGE, true},
             {V4L2_COLORSPACE_JPEG, V4L2_QUANTIZATION_DEFAULT, true},
             {V4L2_COLORSPACE_JPEG, V4L2_QUANTIZATION_LIM_RANGE, false}}) {
      FakeV4l2State state;
      MakeGrey(&state);
      state.has_planes_apart = are_apart;
      state.formats[0].colour_space = colour_space;
      state.formats[0].quantization = quantization;
      EXPECT_EQ(Open(&state)->format().is_full_range, is_full);
    }
}

TEST(V4l2Source, DamagedFramesGoBackToTheDriverAndAreNeverSeen) {
  FakeV4l2State state;
  MakeGrey(&state);
  for (int i = 0; i < 10; ++i) {
    Event short_frame = Frame(1);
    short_frame.missing = kStride - kWidth + 1;
    Event bad_frame = Frame(2);
    bad_frame.flags = V4L2_BUF_FLAG_ERROR;
    state.events.push_back(short_frame);
    state.events.push_back(bad_frame);
  }
  // The gap behind the last row need not be there.
  Event good = Frame(9);
  good.missing = kStride - kWidth;
  state.events.push_back(good);
  const auto source = Open(&state);
  source->Start();
  EXPECT_EQ(NextValue(source.get()), 9);
  EXPECT_EQ(source->counts().damaged, 20u);
  EXPECT_EQ(source->counts().arrived, 1u);
  EXPECT_EQ(state.num_queued, 4 + 20 + 1);
}

TEST(V4l2Source, SlowTakersGetTheNewestFrames) {
  FakeV4l2State state;
  MakeGrey(&state);
  for (uint8_t i = 0; i < 50; ++i) state.events.push_back(Frame(i, i));
  const auto source = Open(&state, {"", kWidth, kHeight, false, {}});
  source->Start();
  while (source->counts().arrived < 50) std::this_thread::yield();
  EXPECT_EQ(NextValue(source.get()), 48);
  EXPECT_EQ(NextValue(source.get()), 49);
  EXPECT_EQ(source->counts().dropped, 48u);
}

TEST(V4l2Source, AnUnpluggedCameraEndsIt) {
  FakeV4l2State state;
  MakeGrey(&state);
  state.events = {Frame(5), Failure(ENODEV)};
  const auto source = Open(&state);
  source->Start();
  EXPECT_EQ(NextValue(source.get()), 5);
  EXPECT_EQ(NextValue(source.get()), -1);
  EXPECT_TRUE(source->is_finished());
  EXPECT_EQ(source->fault(), "camera: disconnected; reconnect it");

  FakeV4l2State hung_up;
  MakeGrey(&hung_up);
  hung_up.error_events = POLLERR | POLLHUP;
  const auto other = Open(&hung_up);
  other->Start();
  EXPECT_EQ(NextValue(other.get()), -1);
  EXPECT_EQ(other->fault(), "camera: disconnected; reconnect it");
}

TEST(V4l2Source, ACameraIsUnpluggedWhileAFrameIsHeld) {
  FakeV4l2State state;
  MakeGrey(&state);
  state.events = {Frame(5)};
  const auto source = Open(&state);
  source->Start();
  const auto frame = source->Next(kSoon);
  ASSERT_TRUE(frame);
  state.errors[VIDIOC_QBUF] = {ENODEV};
  source->Release(*frame);
  EXPECT_FALSE(source->Next(kNow));
  EXPECT_TRUE(source->is_finished());
  EXPECT_EQ(source->fault(), "camera: disconnected; reconnect it");
}

TEST(V4l2Source, ItGoesOnAfterErrorsThatPass) {
  FakeV4l2State state;
  MakeGrey(&state);
  state.errors[VIDIOC_STREAMON] = {EINTR};
  state.errors[VIDIOC_QBUF] = {EINTR, EINTR};
  state.errors[VIDIOC_S_FMT] = {EINTR};
  state.events = {Failure(EINTR), Failure(EIO), Failure(EAGAIN),
                  Frame(5),       Failure(EIO), Frame(6)};
  const auto source = Open(&state);
  source->Start();
  EXPECT_EQ(NextValue(source.get()), 5);
  EXPECT_EQ(NextValue(source.get()), 6);
  EXPECT_EQ(source->fault(), "");
}

TEST(V4l2Source, ErrorsThatStayEndIt) {
  FakeV4l2State state;
  MakeGrey(&state);
  for (int i = 0; i < 100; ++i) state.events.push_back(Failure(EIO));
  const auto source = Open(&state);
  source->Start();
  EXPECT_EQ(NextValue(source.get()), -1);
  EXPECT_NE(source->fault().find("Input/output error"), std::string::npos);

  FakeV4l2State failed;
  MakeGrey(&failed);
  failed.error_events = POLLERR;
  const auto other = Open(&failed);
  other->Start();
  EXPECT_EQ(NextValue(other.get()), -1);
  EXPECT_NE(other->fault().find("reconnect it"), std::string::npos);
}

TEST(V4l2Source, WhatCannotBeStreamedIsRefused) {
  const V4l2Options options = {"", kWidth, kHeight, true, {}};
  for (const auto& [request, error, word] :
       std::vector<std::tuple<unsigned long, int, std::string>>{
           {VIDIOC_S_FMT, EBUSY, "in use by another process"},
           {VIDIOC_S_FMT, EINVAL, "rejects the format"},
           {VIDIOC_TRY_FMT, EINVAL, "rejects all of its formats"},
           {VIDIOC_REQBUFS, EBUSY, "in use by another process"},
           {VIDIOC_REQBUFS, ENOMEM, "cannot allocate"},
           {VIDIOC_QUERYBUF, EINVAL, "cannot query its buffers"},
           {VIDIOC_QBUF, EINVAL, "does not accept buffers"},
           {VIDIOC_STREAMON, ENOSPC, "other cameras"},
           {VIDIOC_STREAMON, EPIPE, "media-ctl"},
           {VIDIOC_STREAMON, ENODEV, "disconnected"},
           {VIDIOC_QUERYCAP, ENOTTY, "does not respond"}}) {
    FakeV4l2State state;
    MakeGrey(&state);
    state.errors[request] = {error, error};
    ExpectRefused(&state, options, word);
  }
  FakeV4l2State metadata;
  MakeGrey(&metadata);
  metadata.capabilities = 0;
  ExpectRefused(&metadata, options, "does not deliver frames");
  FakeV4l2State compressed;
  MakeGrey(&compressed);
  compressed.formats[0].code = V4L2_PIX_FMT_MJPEG;
  ExpectRefused(&compressed, options,
                "no pixel format that can be undistorted");
  FakeV4l2State small;
  MakeGrey(&small);
  small.formats[0].sizes = {kStride * kHeight - kStride};
  ExpectRefused(&small, options, "smaller than its frames");
  FakeV4l2State grey;
  MakeGrey(&grey);
  ExpectRefused(&grey, {"NV12", kWidth, kHeight, true, {}},
                "no pixel format NV12");
}

TEST(V4l2Source, TheFormatThatHasTheSizeIsChosen) {
  FakeV4l2State state;
  state.formats = {{V4L2_PIX_FMT_MJPEG, 64, 48, {0}, {9000}},
                   {V4L2_PIX_FMT_YUYV, 32, 24, {64}, {64 * 24}},
                   {V4L2_PIX_FMT_NV12, 64, 48, {80}, {80 * 72}},
                   {V4L2_PIX_FMT_GREY, 64, 48, {64}, {64 * 48}}};
  const auto source = Open(&state);
  EXPECT_STREQ(source->format().pixel_format->name, "NV12");
  EXPECT_EQ(source->format().planes[1].stride, 80u);
  // The driver's size, for the guard to judge.
  const auto other = Open(&state, {"YUYV", 64, 48, true, {}});
  EXPECT_EQ(other->format().width, 32);
}

// A picture of one colour.
std::string MakeJpeg(uint8_t value, unsigned width = kWidth) {
  const StreamFormat format =
      MakeStreamFormat(*FindPixelFormat("BGR888"), width, kHeight, 0);
  JpegEncoder encoder(format);
  const std::vector<uint8_t> pixels(format.packed_size(), value);
  const uint8_t* const planes[3] = {pixels.data()};
  const size_t size = encoder.Encode(MakeImage(format, planes));
  return std::string(encoder.bytes(), encoder.bytes() + size);
}

Event Jpeg(const std::string& bytes) {
  Event event;
  event.jpeg = bytes;
  return event;
}

void MakeJpegCamera(FakeV4l2State* state) {
  state->formats = {{V4L2_PIX_FMT_YUYV, 32, 24, {64}, {64 * 24}},
                    {V4L2_PIX_FMT_MJPEG, kWidth, kHeight, {0}, {20000}}};
}

TEST(V4l2Source, JpegsAreTakenWhereTheyAloneHaveTheSize) {
  FakeV4l2State state;
  MakeJpegCamera(&state);
  V4l2Options options = {"", kWidth, kHeight, true, {}, DecodeJpeg};
  const std::string picture = MakeJpeg(100);
  Event no_bytes = Jpeg(picture);
  no_bytes.missing = static_cast<uint32_t>(picture.size());
  state.events = {Jpeg(MakeJpeg(50)),
                  Jpeg(picture.substr(0, picture.size() / 2)),
                  Jpeg(MakeJpeg(70, 2 * kWidth)), no_bytes, Jpeg(picture)};
  {
    const auto source = Open(&state, options);
    EXPECT_STREQ(source->format().pixel_format->name, "BGR888");
    EXPECT_EQ(source->format().width, kWidth);
    source->Start();
    EXPECT_NEAR(NextValue(source.get()), 50, 1);
    EXPECT_NEAR(NextValue(source.get()), 100, 1);
    EXPECT_EQ(source->counts().arrived, 2u);
    EXPECT_EQ(source->counts().damaged, 3u);
    EXPECT_EQ(state.num_queued, 4 + 5);
  }
  options.format = "YUYV";
  EXPECT_STREQ(Open(&state, options)->format().pixel_format->name, "YUYV");
  options.format = "MJPEG";
  EXPECT_STREQ(Open(&state, options)->format().pixel_format->name, "BGR888");
  options = {"", 32, 24, true, {}, DecodeJpeg};
  EXPECT_STREQ(Open(&state, options)->format().pixel_format->name, "YUYV");
}

TEST(V4l2Source, OldPixelsOfJpegsAreDropped) {
  FakeV4l2State state;
  MakeJpegCamera(&state);
  state.heaps = {"/dev/dma_heap/system"};
  for (int i = 0; i < 20; ++i)
    state.events.push_back(Jpeg(MakeJpeg(static_cast<uint8_t>(10 * i))));
  const auto source =
      Open(&state, {"MJPEG", kWidth, kHeight, false, {}, DecodeJpeg});
  source->Start();
  while (source->counts().arrived < 20) std::this_thread::yield();
  EXPECT_NEAR(NextValue(source.get()), 180, 1);
  EXPECT_NEAR(NextValue(source.get()), 190, 1);
  EXPECT_EQ(source->counts().dropped, 18u);
  EXPECT_EQ(state.num_begun, 20);
  EXPECT_EQ(state.num_ended, 20);
}

TEST(V4l2Source, PlanesMayLieInMemoriesOfTheirOwn) {
  for (const bool has_heap : {false, true}) {
    FakeV4l2State state;
    state.has_planes_apart = true;
    state.formats = {{V4L2_PIX_FMT_YUV420M,
                      64,
                      48,
                      {80, 48, 48},
                      {80 * 48, 48 * 24, 48 * 24}}};
    if (has_heap) state.heaps = {"/dev/dma_heap/system"};
    Event short_frame = Frame(1);
    short_frame.missing = 48 - 32 + 1;
    state.events = {short_frame, Frame(3)};
    const auto source = Open(&state);
    EXPECT_EQ(source->format().planes[2].stride, 48u);
    source->Start();
    EXPECT_EQ(NextValue(source.get()), 3);
    EXPECT_EQ(source->counts().damaged, 1u);
    EXPECT_EQ(state.num_begun, has_heap ? 3 : 0);
  }
}

TEST(V4l2Source, OnePlanesApartMemoryMayHoldAll) {
  FakeV4l2State state;
  state.has_planes_apart = true;
  state.formats = {{V4L2_PIX_FMT_NV12, 64, 48, {80}, {80 * 72}}};
  state.events = {Frame(3)};
  const auto source = Open(&state);
  source->Start();
  EXPECT_EQ(NextValue(source.get()), 3);
}

TEST(V4l2Source, MemoryOfAHeapIsTakenAndKeptInStep) {
  FakeV4l2State state;
  MakeGrey(&state);
  state.heaps = {"/dev/dma_heap/system"};
  state.events = {Frame(3), Frame(4)};
  auto source = Open(&state);
  EXPECT_EQ(source->memory(), "/dev/dma_heap/system, cached");
  EXPECT_EQ(state.dma_bufs.size(), 4u);
  source->Start();
  const auto frame = source->Next(kSoon);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->image.planes[0].data[0], 3);
  EXPECT_EQ(state.num_ended, 0);
  source->Release(*frame);
  EXPECT_EQ(NextValue(source.get()), 4);
  EXPECT_EQ(state.num_begun, 2);
  EXPECT_EQ(state.num_ended, 2);
  source.reset();
  EXPECT_TRUE(state.dma_bufs.empty());
  EXPECT_EQ(state.num_mapped, 0);
}

TEST(V4l2Source, MemoryThatNeedsNoCallIsAskedOnce) {
  FakeV4l2State state;
  MakeGrey(&state);
  state.heaps = {"/dev/dma_heap/system"};
  state.sync_error = ENOTTY;
  state.events = {Frame(3), Frame(4)};
  const auto source = Open(&state);
  source->Start();
  EXPECT_EQ(NextValue(source.get()), 3);
  EXPECT_EQ(NextValue(source.get()), 4);
  EXPECT_EQ(state.num_begun + state.num_ended, 1);
}

TEST(V4l2Source, MemoryThatCannotBeReadIsADamagedFrame) {
  FakeV4l2State state;
  MakeGrey(&state);
  state.heaps = {"/dev/dma_heap/system"};
  state.sync_error = EIO;
  state.events = {Frame(3)};
  const auto source = Open(&state);
  source->Start();
  while (source->counts().damaged == 0) std::this_thread::yield();
  EXPECT_FALSE(source->Next(kNow));
}

TEST(V4l2Source, OtherMemoryIsTakenWhereAHeapsIsRefused) {
  FakeV4l2State other_heap;
  MakeGrey(&other_heap);
  other_heap.heaps = {"/dev/dma_heap/system", "/dev/dma_heap/linux,cma"};
  other_heap.refused_heap = "/dev/dma_heap/system";
  other_heap.events = {Frame(6)};
  const auto source = Open(&other_heap);
  EXPECT_EQ(source->memory(), "/dev/dma_heap/linux,cma, cached");
  EXPECT_EQ(other_heap.dma_bufs.size(), 4u);
  source->Start();
  EXPECT_EQ(NextValue(source.get()), 6);

  FakeV4l2State no_dmabuf;
  MakeGrey(&no_dmabuf);
  no_dmabuf.heaps = {"/dev/dma_heap/system"};
  no_dmabuf.takes_dmabuf = false;
  EXPECT_EQ(Open(&no_dmabuf)->memory(), "the driver's");

  FakeV4l2State cached;
  MakeGrey(&cached);
  cached.has_cache_hints = true;
  const auto hinted = Open(&cached);
  EXPECT_EQ(hinted->memory(), "the driver's, cached");
  EXPECT_EQ(cached.request_flags, uint32_t{V4L2_MEMORY_FLAG_NON_COHERENT});
}

FakeV4l2State::Control Whole(uint32_t id, const std::string& name,
                             long long minimum, long long maximum,
                             long long step, uint32_t flags = 0) {
  return {id, V4L2_CTRL_TYPE_INTEGER, name, minimum, maximum, step, 0, flags,
          {}};
}

void MakeControls(FakeV4l2State* state) {
  MakeGrey(state);
  state->controls = {
      Whole(5, "Gain", -64, 64, 2),
      {6,
       V4L2_CTRL_TYPE_MENU,
       "Auto Exposure",
       0,
       3,
       1,
       3,
       0,
       {"", "Manual Mode", "", "Aperture Priority Mode"}},
      Whole(7, "Exposure Time, Absolute", 3, 2047, 1, V4L2_CTRL_FLAG_INACTIVE),
      Whole(8, "Serial", 0, 9, 1, V4L2_CTRL_FLAG_READ_ONLY)};
}

TEST(V4l2Controls, AreSetByNameInTheOrderGiven) {
  FakeV4l2State state;
  MakeControls(&state);
  Open(&state, {"",
                kWidth,
                kHeight,
                true,
                {{"gain", "-62"},
                 {"auto_exposure", "Manual Mode"},
                 {"exposure_time_absolute", "0x64"}}});
  EXPECT_EQ(state.controls[0].value, -62);
  EXPECT_EQ(state.controls[1].value, 1);
  EXPECT_EQ(state.controls[2].value, 100);
}

TEST(V4l2Controls, OnesThatHaveNoEffectAreRefused) {
  for (const auto& [name, value, word] :
       std::vector<std::tuple<std::string, std::string, std::string>>{
           {"exposure_time_absolute", "100", "is inactive"},
           {"gain", "66", "-64 to 64 in steps of 2"},
           {"gain", "3", "in steps of 2"},
           {"gain", "much", "cannot be set to much"},
           {"gain", "99999999999999999999", "-64 to 64"},
           {"auto_exposure", "2", "1 Manual Mode, 3 Aperture"},
           {"auto_exposure", "Manual", "1 Manual Mode"},
           {"serial", "1", "no settable control serial"},
           {"iris", "1", "no settable control iris"}}) {
    FakeV4l2State state;
    MakeControls(&state);
    ExpectRefused(&state, {"", kWidth, kHeight, true, {{name, value}}}, word);
  }
  FakeV4l2State refusing;
  MakeControls(&refusing);
  refusing.errors[VIDIOC_S_EXT_CTRLS] = {EIO};
  ExpectRefused(&refusing, {"", kWidth, kHeight, true, {{"gain", "2"}}},
                "Input/output error");
}

TEST(V4l2List, TellsFormatsAndControls) {
  FakeV4l2State state;
  MakeControls(&state);
  state.formats.push_back({V4L2_PIX_FMT_MJPEG, 64, 48, {0}, {9000}});
  state.formats.push_back({V4L2_PIX_FMT_H264, 64, 48, {0}, {9000}});
  FakeV4l2Device device(&state);
  const std::string text = DescribeV4l2Device(&device);
  EXPECT_EQ(text.find("v4l2:/dev/fake (Fake"), 0u) << text;
  EXPECT_NE(text.find("\n  R8\n  MJPEG\n  H264 (not supported)\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("--control gain=-64 to 64 in steps of 2\n"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("serial"), std::string::npos) << text;
}

TEST(V4l2Formats, CodesAreThoseOfTheKernelsHeader) {
  for (const auto& [code, name] : std::vector<std::pair<uint32_t, std::string>>{
           {V4L2_PIX_FMT_BGR24, "RGB888"},
           {V4L2_PIX_FMT_RGB24, "BGR888"},
           {V4L2_PIX_FMT_XBGR32, "XRGB8888"},
           {V4L2_PIX_FMT_RGBX32, "XBGR8888"},
           {V4L2_PIX_FMT_BGRX32, "RGBX8888"},
           {V4L2_PIX_FMT_XRGB32, "BGRX8888"},
           {V4L2_PIX_FMT_YVU420, "YVU420"},
           {V4L2_PIX_FMT_YVU420M, "YVU420"},
           {V4L2_PIX_FMT_SBGGR8, "SBGGR8"},
           {V4L2_PIX_FMT_SGRBG10, "SGRBG10"},
           {V4L2_PIX_FMT_SBGGR16, "SBGGR16"},
           {V4L2_PIX_FMT_SGRBG12P, "SGRBG12_CSI2P"}})
    EXPECT_EQ(V4l2FormatName(code), name);
  EXPECT_FALSE(FindV4l2Format(V4L2_PIX_FMT_MJPEG));
}

}  // namespace
}  // namespace raygrid
