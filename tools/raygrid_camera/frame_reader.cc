#include "frame_reader.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "camera_error.h"
#include "jpeg_reader.h"
#include "rg_blob.h"

namespace raygrid {
namespace {

constexpr char kY4mMagic[] = "YUV4MPEG2 ", kY4mFrame[] = "FRAME";
constexpr char kY4mFullRange[] = " XCOLORRANGE=FULL ";
constexpr size_t kMaxLineBytes = 1024;

CameraError InputError(const std::string& message) {
  return CameraError(CameraExit::kInput, "standard input: " + message);
}

// Reads consecutive planes.
FrameReader::Outcome ReadPlanes(InputStream* stream, const StreamFormat& format,
                                uint8_t* frame) {
  const size_t size = format.packed_size();
  const size_t came = stream->Read(frame, size);
  if (came == size) return FrameReader::Outcome::kComplete;
  return came == 0 ? FrameReader::Outcome::kEnd
                   : FrameReader::Outcome::kTruncated;
}

bool BeginsWith(InputStream* stream, const char* text, size_t length) {
  return stream->Await(length) >= length &&
         std::memcmp(stream->data(), text, length) == 0;
}

class RawReader : public FrameReader {
 public:
  RawReader(InputStream* stream, const StreamFormat& format)
      : stream_(stream), format_(format) {}
  const StreamFormat& format() const override { return format_; }
  Outcome Read(uint8_t* frame) override {
    return ReadPlanes(stream_, format_, frame);
  }
  const char* remedy() const override { return "check --size and --format"; }

 private:
  InputStream* const stream_;
  const StreamFormat format_;
};

// Reads a line, without its line break; returns false if it is too long or
// incomplete.
bool ReadLine(InputStream* stream, std::string* line) {
  for (size_t length = 0; length < kMaxLineBytes; ++length) {
    if (stream->Await(length + 1) <= length) return false;
    if (stream->data()[length] != '\n') continue;
    line->assign(stream->data(), stream->data() + length);
    stream->Take(length + 1);
    return true;
  }
  return false;
}

// Returns the value of a parameter such as W640; empty if it is missing.
std::string Parameter(const std::string& line, char letter) {
  const size_t start = line.find(std::string(" ") + letter);
  if (start == std::string::npos) return "";
  return line.substr(start + 2, line.find(' ', start + 1) - start - 2);
}

unsigned ParseSide(const std::string& line, char letter) {
  const std::string text = Parameter(line, letter);
  char* end;
  const unsigned long value = std::strtoul(text.c_str(), &end, 10);
  if (text.empty() || *end != 0 || value == 0 || value > RG_MAX_IMAGE_SIZE)
    throw InputError("the Y4M header has no valid size, such as W640 H480");
  return static_cast<unsigned>(value);
}

const char* ConvertY4mFormat(const std::string& colours) {
  for (const char* name : {"", "420", "420jpeg", "420mpeg2", "420paldv"})
    if (colours == name) return "YUV420";
  if (colours == "mono") return "R8";
  throw InputError(
      "Y4M colour space " + colours +
      " is not supported; convert it with ffmpeg -pix_fmt yuv420p");
}

class Y4mReader : public FrameReader {
 public:
  explicit Y4mReader(InputStream* stream)
      : stream_(stream), format_(ReadHeader(stream)) {}
  const StreamFormat& format() const override { return format_; }

  Outcome Read(uint8_t* frame) override {
    constexpr size_t kLength = sizeof(kY4mFrame) - 1;
    const size_t came = stream_->Await(kLength);
    if (came < kLength) return came == 0 ? Outcome::kEnd : Outcome::kTruncated;
    if (!BeginsWith(stream_, kY4mFrame, kLength))
      throw InputError(
          "a Y4M frame does not begin with FRAME; the stream is corrupt");
    std::string line;
    if (!ReadLine(stream_, &line)) return Outcome::kTruncated;
    const Outcome outcome = ReadPlanes(stream_, format_, frame);
    return outcome == Outcome::kEnd ? Outcome::kTruncated : outcome;
  }

 private:
  static StreamFormat ReadHeader(InputStream* stream) {
    std::string line;
    if (!ReadLine(stream, &line))
      throw InputError(
          "the Y4M header is not terminated; the stream is corrupt");
    StreamFormat format = MakeStreamFormat(
        *FindPixelFormat(ConvertY4mFormat(Parameter(line, 'C'))),
        ParseSide(line, 'W'), ParseSide(line, 'H'), 0);
    format.is_full_range =
        (line + " ").find(kY4mFullRange) != std::string::npos;
    return format;
  }

  InputStream* const stream_;
  const StreamFormat format_;
};

}  // namespace

std::unique_ptr<FrameReader> MakeFrameReader(InputStream* stream,
                                             const std::string& format,
                                             unsigned width, unsigned height) {
  if (stream->Await(1) == 0) throw InputError("is empty; pipe frames to it");
  if (BeginsWith(stream, kY4mMagic, sizeof(kY4mMagic) - 1)) {
    if (!format.empty())
      throw InputError(
          "is Y4M, whose header specifies the format; omit --format");
    return std::make_unique<Y4mReader>(stream);
  }
  if (format == "MJPEG" ||
      (format.empty() && BeginsWith(stream, "\xff\xd8\xff", 3)))
    return MakeJpegReader(stream);
  if (format.empty())
    throw InputError(
        "is neither Y4M nor JPEG; specify its format with --format");
  return std::make_unique<RawReader>(
      stream, MakeStreamFormat(RequirePixelFormat(format), width, height, 0));
}

}  // namespace raygrid
