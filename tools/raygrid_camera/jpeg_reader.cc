#include "jpeg_reader.h"

#include <csetjmp>
#include <cstdio>
#include <cstring>

// Requires the headers above.
#include <jerror.h>
#include <jpeglib.h>

#include "camera_error.h"

namespace raygrid {
namespace {

// Larger data is not accepted as an image.
constexpr size_t kMaxImageBytes = size_t{1} << 28;

// JPEG markers, which follow a byte 0xff.
enum Marker : uint8_t {
  kStuffing = 0x00,
  kTemporary = 0x01,
  kFirstRestart = 0xd0,
  kLastRestart = 0xd7,
  kStartOfImage = 0xd8,
  kEndOfImage = 0xd9,
  kStartOfScan = 0xda,
  kFill = 0xff
};

bool IsRestart(uint8_t marker) {
  return marker >= kFirstRestart && marker <= kLastRestart;
}

struct ReaderErrors {
  jpeg_error_mgr manager;
  std::jmp_buf leave;
  bool is_damaged;
};

void LeaveReader(j_common_ptr jpeg) {
  std::longjmp(reinterpret_cast<ReaderErrors*>(jpeg->err)->leave, 1);
}

// Records corrupt data. Extraneous bytes, which many cameras write, do not
// affect pixels.
void NoteDamage(j_common_ptr jpeg, int level) {
  if (level < 0 && jpeg->err->msg_code != JWRN_EXTRANEOUS_DATA)
    reinterpret_cast<ReaderErrors*>(jpeg->err)->is_damaged = true;
}

void StartReader(jpeg_decompress_struct* jpeg, ReaderErrors* errors) {
  jpeg->err = jpeg_std_error(&errors->manager);
  errors->manager.error_exit = LeaveReader;
  errors->manager.emit_message = NoteDamage;
  errors->is_damaged = false;
  jpeg_create_decompress(jpeg);
}

struct JpegSize {
  unsigned width, height;
  bool is_grey;
};

bool operator==(const JpegSize& a, const JpegSize& b) {
  return a.width == b.width && a.height == b.height && a.is_grey == b.is_grey;
}

JpegSize GetJpegSize(const jpeg_decompress_struct& jpeg) {
  return {jpeg.image_width, jpeg.image_height,
          jpeg.jpeg_color_space == JCS_GRAYSCALE};
}

// libjpeg reports errors by longjmp: no local variable of the next two
// functions may have a destructor.
bool ReadJpegSize(const uint8_t* bytes, size_t number, JpegSize* size) {
  jpeg_decompress_struct jpeg;
  ReaderErrors errors;
  StartReader(&jpeg, &errors);
  if (setjmp(errors.leave)) {
    jpeg_destroy_decompress(&jpeg);
    return false;
  }
  jpeg_mem_src(&jpeg, bytes, number);
  jpeg_read_header(&jpeg, TRUE);
  *size = GetJpegSize(jpeg);
  jpeg_destroy_decompress(&jpeg);
  return true;
}

// Returns whether all pixels were decoded without errors.
bool Decompress(const uint8_t* bytes, size_t number, bool as_grey,
                uint8_t* frame, size_t row_bytes) {
  jpeg_decompress_struct jpeg;
  ReaderErrors errors;
  StartReader(&jpeg, &errors);
  if (setjmp(errors.leave)) {
    jpeg_destroy_decompress(&jpeg);
    return false;
  }
  jpeg_mem_src(&jpeg, bytes, number);
  jpeg_read_header(&jpeg, TRUE);
  jpeg.out_color_space = as_grey ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_start_decompress(&jpeg);
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW row = frame + row_bytes * jpeg.output_scanline;
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_decompress(&jpeg);
  jpeg_destroy_decompress(&jpeg);
  return !errors.is_damaged;
}

class JpegReader : public FrameReader {
 public:
  explicit JpegReader(InputStream* stream) : stream_(stream) {
    for (;;) {
      const Outcome outcome = FindImage();
      if (outcome == Outcome::kEnd || outcome == Outcome::kTruncated)
        throw CameraError(
            CameraExit::kInput,
            "standard input: contains no complete JPEG; check --format");
      if (outcome == Outcome::kDamaged) continue;
      if (ReadJpegSize(stream_->data(), image_bytes_, &size_)) break;
      stream_->Take(image_bytes_);
    }
    format_ =
        MakeStreamFormat(*FindPixelFormat(size_.is_grey ? "R8" : "BGR888"),
                         size_.width, size_.height, 0);
  }

  const StreamFormat& format() const override { return format_; }

  Outcome Read(uint8_t* frame) override {
    const Outcome outcome = FindImage();
    if (outcome != Outcome::kComplete) return outcome;
    JpegSize size;
    bool is_good = ReadJpegSize(stream_->data(), image_bytes_, &size);
    if (is_good && !(size == size_))
      throw CameraError(CameraExit::kInput,
                        "standard input: image size changed to " +
                            std::to_string(size.width) + "x" +
                            std::to_string(size.height) + " from " +
                            std::to_string(size_.width) + "x" +
                            std::to_string(size_.height) +
                            "; all images must have the same size and colours");
    is_good =
        is_good && Decompress(stream_->data(), image_bytes_, size_.is_grey,
                              frame, format_.planes[0].row_bytes);
    stream_->Take(image_bytes_);
    return is_good ? Outcome::kComplete : Outcome::kDamaged;
  }

 private:
  bool Has(size_t number) { return stream_->Await(number) >= number; }

  // Skips the bytes before an image.
  bool SkipToImage() {
    while (Has(3)) {
      const uint8_t* const bytes = stream_->data();
      if (bytes[0] == 0xff && bytes[1] == kStartOfImage && bytes[2] == 0xff)
        return true;
      const size_t number = stream_->Await(3);
      const void* const next = std::memchr(bytes + 1, 0xff, number - 1);
      stream_->Take(
          next ? static_cast<size_t>(static_cast<const uint8_t*>(next) - bytes)
               : number);
    }
    return false;
  }

  // Advances past the entropy-coded data that starts at a position.
  bool SkipScan(size_t* place) {
    while (Has(*place + 2)) {
      const uint8_t* const bytes = stream_->data();
      const size_t number = stream_->Await(*place + 2);
      const void* const next =
          std::memchr(bytes + *place, 0xff, number - *place - 1);
      if (!next) {
        *place = number - 1;
        continue;
      }
      *place = static_cast<size_t>(static_cast<const uint8_t*>(next) - bytes);
      const uint8_t marker = bytes[*place + 1];
      if (marker != kStuffing && !IsRestart(marker) && marker != kFill)
        return true;
      *place += marker == kFill ? 1 : 2;
    }
    return false;
  }

  Outcome Drop(size_t number) {
    stream_->Take(number);
    return Outcome::kDamaged;
  }

  // Waits for a complete image; truncated images are dropped.
  Outcome FindImage() {
    if (!SkipToImage()) return Outcome::kEnd;
    size_t place = 2;
    while (Has(place + 2)) {
      const uint8_t* const bytes = stream_->data() + place;
      const uint8_t marker = bytes[1];
      if (bytes[0] != 0xff || place > kMaxImageBytes) return Drop(2);
      if (marker == kStartOfImage) return Drop(place);
      if (marker == kEndOfImage) {
        image_bytes_ = place + 2;
        return Outcome::kComplete;
      }
      if (marker == kFill) {
        ++place;
      } else if (marker == kTemporary || IsRestart(marker)) {
        place += 2;
      } else {
        if (!Has(place + 4)) break;
        const uint8_t* const segment = stream_->data() + place;
        const size_t length = segment[2] * size_t{256} + segment[3];
        if (length < 2) return Drop(2);
        place += 2 + length;
        if (marker == kStartOfScan && !SkipScan(&place)) break;
      }
    }
    return Outcome::kTruncated;
  }

  InputStream* const stream_;
  StreamFormat format_;
  JpegSize size_ = {};
  size_t image_bytes_ = 0;
};

}  // namespace

bool DecodeJpeg(const uint8_t* bytes, size_t number, const StreamFormat& format,
                uint8_t* frame) {
  const bool as_grey = format.pixel_format->model == ColourModel::kGrey;
  JpegSize size;
  return ReadJpegSize(bytes, number, &size) && size.width == format.width &&
         size.height == format.height && (size.is_grey || !as_grey) &&
         Decompress(bytes, number, as_grey, frame, format.planes[0].row_bytes);
}

std::unique_ptr<FrameReader> MakeJpegReader(InputStream* stream) {
  return std::make_unique<JpegReader>(stream);
}

}  // namespace raygrid
