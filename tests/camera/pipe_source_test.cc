#include "pipe_source.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <string>
#include <thread>

#include "camera_error.h"
#include "camera_support.h"
#include "jpeg_encoder.h"

namespace raygrid {
namespace {

// A pipe whose writer is a thread.
class Writer {
 public:
  Writer() { EXPECT_EQ(pipe(ends_), 0); }
  ~Writer() {
    if (thread_.joinable()) thread_.join();
    close(ends_[0]);
    End();
  }
  int fd() const { return ends_[0]; }
  // Bytes, some at a time, then the end.
  void Write(std::string bytes, size_t piece) {
    thread_ = std::thread([this, text = std::move(bytes), piece] {
      for (size_t i = 0; i < text.size(); i += piece) {
        const size_t number = std::min(piece, text.size() - i);
        if (write(ends_[1], text.data() + i, number) !=
            static_cast<ssize_t>(number))
          break;
      }
      End();
    });
  }
  void End() {
    if (ends_[1] >= 0) close(ends_[1]);
    ends_[1] = -1;
  }

 private:
  int ends_[2];
  std::thread thread_;
};

struct Played {
  std::vector<std::string> frames;
  std::string fault;
  SourceCounts counts;
  std::string format;
};

PipeOptions Options(const std::string& format, unsigned width = 16,
                    unsigned height = 8) {
  PipeOptions options;
  options.format = format;
  options.width = width;
  options.height = height;
  options.every_frame = true;
  return options;
}

// The bytes of all planes of all frames.
Played Play(const std::string& bytes, const PipeOptions& options,
            size_t piece = 65536) {
  Writer writer;
  writer.Write(bytes, piece);
  PipeSource source(writer.fd(), options, [] { return false; });
  source.Start();
  Played played;
  while (!source.is_finished()) {
    const auto frame = source.Next(std::chrono::milliseconds(100));
    if (!frame) continue;
    std::string planes;
    for (int i = 0; i < source.format().num_planes; ++i)
      planes.append(reinterpret_cast<const char*>(frame->image.planes[i].data),
                    source.format().planes[i].extent());
    played.frames.push_back(planes);
    source.Release(*frame);
  }
  played.fault = source.fault();
  played.counts = source.counts();
  played.format = source.format().pixel_format->name;
  return played;
}

void ExpectRefused(const std::string& bytes, const PipeOptions& options,
                   const std::string& word) {
  try {
    Play(bytes, options);
    FAIL() << word;
  } catch (const CameraError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find(word), std::string::npos) << what;
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
  }
}

std::string Text(const std::vector<uint8_t>& bytes) {
  return std::string(bytes.begin(), bytes.end());
}

std::string Recording(const char* format, uint32_t width, uint32_t height,
                      uint32_t num_frames) {
  return Text(MakeRecording(
      MakeStreamFormat(*FindPixelFormat(format), width, height, 0),
      num_frames));
}

TEST(PipeSource, RawFramesComeWhole) {
  const std::string bytes = Recording("NV12", 16, 8, 5);
  for (const size_t piece : {size_t{7}, size_t{192}, size_t{65536}}) {
    const Played played = Play(bytes, Options("NV12"), piece);
    ASSERT_EQ(played.frames.size(), 5u);
    for (size_t i = 0; i < 5; ++i)
      EXPECT_EQ(played.frames[i], bytes.substr(i * 192, 192));
    EXPECT_EQ(played.fault, "");
    EXPECT_EQ(played.counts.arrived, 5u);
  }
}

TEST(PipeSource, HasNoStateThatCanBeLocked) {
  Writer writer;
  writer.Write(Recording("R8", 16, 8, 1), 65536);
  PipeSource source(writer.fd(), Options("R8"), [] { return false; });
  source.Start();
  const StateLock lock = source.LockState();
  source.UnlockState();
  EXPECT_TRUE(lock.locked.empty());
  ASSERT_EQ(lock.open.size(), 4u);
  EXPECT_EQ(lock.open[0], "focus: the source is not a camera");
}

TEST(PipeSource, AFrameThatIsCutIsNoFrame) {
  const Played played =
      Play(Recording("R8", 16, 8, 3).substr(0, 300), Options("R8"));
  EXPECT_EQ(played.frames.size(), 2u);
  EXPECT_NE(played.fault.find("--size"), std::string::npos) << played.fault;
}

TEST(PipeSource, SlowTakersGetTheNewestFrames) {
  Writer writer;
  const std::string bytes = Recording("R8", 16, 8, 20);
  writer.Write(bytes, 65536);
  PipeOptions options = Options("R8");
  options.every_frame = false;
  PipeSource source(writer.fd(), options, [] { return false; });
  source.Start();
  while (source.counts().arrived < 20) std::this_thread::yield();
  const auto frame = source.Next(std::chrono::milliseconds(0));
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->info.sequence, 18u);
  EXPECT_EQ(std::memcmp(frame->image.planes[0].data, &bytes[18 * 128], 128), 0);
  EXPECT_EQ(source.counts().dropped, 18u);
}

TEST(PipeSource, Y4mSaysItsRange) {
  for (const auto& [header, is_full] :
       std::vector<std::pair<std::string, bool>>{
           {"C420jpeg XYSCSS=420JPEG XCOLORRANGE=FULL", true},
           {"XCOLORRANGE=FULL C420mpeg2", true},
           {"C420jpeg XCOLORRANGE=LIMITED", false},
           {"C420jpeg", false}}) {
    Writer writer;
    writer.Write("YUV4MPEG2 W16 H8 " + header + "\nFRAME\n", 65536);
    const PipeSource source(writer.fd(), Options(""), [] { return false; });
    EXPECT_EQ(source.format().is_full_range, is_full) << header;
  }
}

TEST(PipeSource, Y4mSaysItsFormat) {
  const std::string frames = Recording("YUV420", 16, 8, 2);
  const std::string bytes =
      "YUV4MPEG2 W16 H8 F30:1 Ip C420jpeg XYSCSS=420JPEG\nFRAME\n" +
      frames.substr(0, 192) + "FRAME Ip\n" + frames.substr(192);
  for (const size_t piece : {size_t{5}, size_t{65536}}) {
    const Played played = Play(bytes, Options("", 99, 99), piece);
    EXPECT_EQ(played.format, "YUV420");
    ASSERT_EQ(played.frames.size(), 2u);
    EXPECT_EQ(played.frames[0] + played.frames[1], frames);
    EXPECT_EQ(played.fault, "");
  }
  const Played grey = Play(
      "YUV4MPEG2 W16 H8 Cmono\nFRAME\n" + frames.substr(0, 128), Options(""));
  EXPECT_EQ(grey.format, "R8");
  EXPECT_EQ(grey.frames.size(), 1u);
  const Played cut = Play(bytes.substr(0, bytes.size() - 1), Options(""));
  EXPECT_EQ(cut.frames.size(), 1u);
  EXPECT_NE(cut.fault.find("within a frame"), std::string::npos);
  const Played lost = Play("YUV4MPEG2 W16 H8\nFRAME\n" + frames, Options(""));
  EXPECT_EQ(lost.frames.size(), 1u);
  EXPECT_NE(lost.fault.find("FRAME"), std::string::npos);
}

TEST(PipeSource, WhatCannotBeReadIsRefused) {
  ExpectRefused("", Options("R8"), "is empty");
  ExpectRefused("hello, world", Options(""), "--format");
  ExpectRefused("hello, world", Options("NV13"), "NV13 is not supported");
  ExpectRefused("hello, world", Options("MJPEG"), "no complete JPEG");
  ExpectRefused("YUV4MPEG2 W16 H8\n", Options("YUV420"), "omit --format");
  ExpectRefused("YUV4MPEG2 W16 H8 C422\n", Options(""), "yuv420p");
  ExpectRefused("YUV4MPEG2 W16 H8 C420p10\n", Options(""), "yuv420p");
  ExpectRefused("YUV4MPEG2 W16\n", Options(""), "W640 H480");
  ExpectRefused("YUV4MPEG2 W16 H8x\n", Options(""), "W640 H480");
  ExpectRefused("YUV4MPEG2 W16 H99999999999\n", Options(""), "W640 H480");
  ExpectRefused("YUV4MPEG2 W15 H8\n", Options(""), "15x8");
  ExpectRefused("YUV4MPEG2 W16 H8" + std::string(2000, ' '), Options(""),
                "is not terminated");
}

TEST(PipeSource, AWriterThatWritesNothingIsNotWaitedForLong) {
  const Writer writer;
  PipeOptions options = Options("R8");
  options.timeout_s = 0.1;
  EXPECT_THROW(PipeSource(writer.fd(), options, [] { return false; }),
               CameraError);
  EXPECT_THROW(PipeSource(writer.fd(), Options("R8"), [] { return true; }),
               CameraError);
}

TEST(PipeSource, ItStopsWithinAFrame) {
  Writer writer;
  const std::string half = Recording("R8", 16, 8, 1).substr(0, 64);
  PipeOptions options = Options("R8");
  writer.Write(half + half + half, 65536);
  PipeSource source(writer.fd(), options, [] { return false; });
  source.Start();
  EXPECT_TRUE(source.Next(std::chrono::milliseconds(1000)));
  source.Stop();
  EXPECT_FALSE(source.Next(std::chrono::milliseconds(0)));
}

// Smooth pictures in colour, which all differ.
std::vector<std::string> MakeJpegs(const char* format, int number) {
  const StreamFormat stream = LensFormat(format);
  JpegEncoder encoder(stream);
  std::vector<std::string> pictures;
  for (int k = 0; k < number; ++k) {
    std::vector<uint8_t> pixels(stream.packed_size());
    for (size_t i = 0; i < pixels.size(); ++i)
      pixels[i] = static_cast<uint8_t>(i / 97 + 40 * k + (i % 3) * 20);
    const uint8_t* const planes[3] = {pixels.data()};
    const size_t size = encoder.Encode(MakeImage(stream, planes));
    pictures.emplace_back(encoder.bytes(), encoder.bytes() + size);
  }
  return pictures;
}

// The mean of a frame's bytes.
double Mean(const std::string& frame) {
  double sum = 0;
  for (const char byte : frame) sum += static_cast<uint8_t>(byte);
  return sum / static_cast<double>(frame.size());
}

TEST(PipeSource, JpegsBecomeRgb) {
  const std::vector<std::string> pictures = MakeJpegs("BGR888", 3);
  // Between pictures stands what a camera of a network writes there.
  const std::string between = "\r\n--frame\r\nContent-Type: image/jpeg\r\n\r\n";
  std::string bytes;
  for (const std::string& picture : pictures) bytes += picture + between;
  for (const size_t piece : {size_t{13}, size_t{65536}}) {
    const Played played = Play(bytes, Options(""), piece);
    EXPECT_EQ(played.format, "BGR888");
    ASSERT_EQ(played.frames.size(), 3u);
    EXPECT_EQ(played.frames[0].size(), size_t{160 * 120 * 3});
    EXPECT_EQ(played.counts.damaged, 0u);
    EXPECT_EQ(played.fault, "");
    // Blue is 40 more than red, which comes first.
    const std::string& frame = played.frames[0];
    EXPECT_NEAR(static_cast<uint8_t>(frame[8 * 480 + 2]) -
                    static_cast<uint8_t>(frame[8 * 480]),
                40, 6);
  }
  EXPECT_EQ(Play(between + bytes, Options("MJPEG")).frames.size(), 3u);
}

TEST(PipeSource, DamagedJpegsAreNoFrames) {
  const std::vector<std::string> pictures = MakeJpegs("BGR888", 3);
  std::string no_end = pictures[1].substr(0, pictures[1].size() / 2);
  std::string bad_scan = pictures[1];
  for (size_t i = bad_scan.size() / 2; i < bad_scan.size() / 2 + 40; ++i)
    bad_scan[i] = 0x55;
  std::string bad_segment = pictures[1];
  bad_segment[4] = 0;
  bad_segment[5] = 1;
  std::string bad_size = pictures[1];
  const size_t frame_header = bad_size.find("\xff\xc0");
  ASSERT_NE(frame_header, std::string::npos);
  bad_size[frame_header + 5] = 0;
  bad_size[frame_header + 6] = 0;
  for (const std::string& damaged : {no_end, bad_scan, bad_segment, bad_size}) {
    const Played played =
        Play(pictures[0] + damaged + pictures[2], Options(""));
    ASSERT_EQ(played.frames.size(), 2u);
    EXPECT_GE(played.counts.damaged, 1u);
    EXPECT_EQ(played.fault, "");
    EXPECT_GT(std::abs(Mean(played.frames[1]) - Mean(played.frames[0])), 1);
    // A stream may begin with one.
    EXPECT_EQ(Play(damaged + pictures[0] + pictures[2], Options("MJPEG"))
                  .frames.size(),
              2u);
  }
  const Played cut = Play(pictures[0] + no_end, Options(""));
  EXPECT_EQ(cut.frames.size(), 1u);
  EXPECT_NE(cut.fault.find("within a frame"), std::string::npos);
}

TEST(PipeSource, JpegsOfAnotherSizeEndIt) {
  const StreamFormat small =
      MakeStreamFormat(*FindPixelFormat("BGR888"), 16, 8, 0);
  JpegEncoder encoder(small);
  const std::vector<uint8_t> pixels(small.packed_size(), 99);
  const uint8_t* const planes[3] = {pixels.data()};
  const size_t size = encoder.Encode(MakeImage(small, planes));
  const std::string other(encoder.bytes(), encoder.bytes() + size);
  const Played played = Play(MakeJpegs("BGR888", 1)[0] + other, Options(""));
  EXPECT_EQ(played.frames.size(), 1u);
  EXPECT_NE(played.fault.find("image size changed to 16x8 from 160x120"),
            std::string::npos)
      << played.fault;
}

}  // namespace
}  // namespace raygrid
