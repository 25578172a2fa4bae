#include "jpeg_encoder.h"

#include <csetjmp>
#include <cstdio>

// Requires the headers above.
#include <jpeglib.h>

#include "rgb_rows.h"

namespace raygrid {
namespace {

constexpr int kQuality = 80;

struct Errors {
  jpeg_error_mgr manager;
  std::jmp_buf leave;
};

void LeaveOnError(j_common_ptr jpeg) {
  std::longjmp(reinterpret_cast<Errors*>(jpeg->err)->leave, 1);
}

void IgnoreMessage(j_common_ptr) {}

void StartBuffer(j_compress_ptr) {}

// Aborts the compression; called only when the buffer is full.
boolean LeaveOnFullBuffer(j_compress_ptr jpeg) {
  LeaveOnError(reinterpret_cast<j_common_ptr>(jpeg));
  return FALSE;
}

void EndBuffer(j_compress_ptr) {}

// libjpeg reports errors by longjmp: no local variable may have a destructor.
size_t Compress(const StreamFormat& format, const rg_image& image, uint8_t* row,
                uint8_t* bytes, size_t max_size) {
  jpeg_compress_struct jpeg;
  Errors errors;
  jpeg.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = LeaveOnError;
  errors.manager.output_message = IgnoreMessage;
  jpeg_create_compress(&jpeg);
  if (setjmp(errors.leave)) {
    jpeg_destroy_compress(&jpeg);
    return 0;
  }
  jpeg_destination_mgr destination = {};
  destination.next_output_byte = bytes;
  destination.free_in_buffer = max_size;
  destination.init_destination = StartBuffer;
  destination.empty_output_buffer = LeaveOnFullBuffer;
  destination.term_destination = EndBuffer;
  jpeg.dest = &destination;
  jpeg.image_width = image.width;
  jpeg.image_height = image.height;
  jpeg.input_components = 3;
  jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, kQuality, TRUE);
  jpeg.dct_method = JDCT_IFAST;
  jpeg_start_compress(&jpeg, TRUE);
  for (uint32_t y = 0; y < image.height; ++y) {
    ReadRgbRow(format, image, y, row);
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  const size_t size = max_size - destination.free_in_buffer;
  jpeg_destroy_compress(&jpeg);
  return size;
}

}  // namespace

// Images of pure noise compress to about the size of their pixels.
JpegEncoder::JpegEncoder(const StreamFormat& format)
    : format_(format),
      row_(size_t{3} * format.width),
      bytes_(size_t{3} * format.width * format.height + 4096) {}

size_t JpegEncoder::Encode(const rg_image& image) {
  return Compress(format_, image, row_.data(), bytes_.data(), bytes_.size());
}

}  // namespace raygrid
