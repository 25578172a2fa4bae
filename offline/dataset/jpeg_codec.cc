// jpeglib.h requires the types of stdio.h.
#include <cstdio>
// jpeglib.h must precede jerror.h.
#include <jpeglib.h>
// jerror.h requires jpeglib.h.
#include <jerror.h>

#include <csetjmp>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>

#include "dataset/pixel_conversion.h"

namespace raygrid {
namespace {

// On errors, libjpeg leaves its functions by longjmp(). Functions that call
// setjmp() therefore have no local variables with destructors.

struct JpegErrors {
  jpeg_error_mgr manager;
  jmp_buf failure;
};

// Whether a warning indicates corrupt data, which libjpeg only warns about.
bool IsDamage(int warning) {
  return warning == JWRN_ARITH_BAD_CODE || warning == JWRN_EXTRANEOUS_DATA ||
         warning == JWRN_HIT_MARKER || warning == JWRN_HUFF_BAD_CODE ||
         warning == JWRN_JPEG_EOF || warning == JWRN_MUST_RESYNC;
}

void FailJpeg(j_common_ptr info) {
  longjmp(reinterpret_cast<JpegErrors*>(info->err)->failure, 1);
}

// Treats warnings about corrupt data as errors; levels >= 0 are trace messages.
void ReceiveJpegMessage(j_common_ptr info, int level) {
  if (level < 0 && IsDamage(info->err->msg_code)) FailJpeg(info);
}

bool DecodeJpegFile(const std::string& bytes, PixelConversion conversion,
                    cv::Mat* pixels) {
  jpeg_decompress_struct info;
  JpegErrors errors;
  info.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = FailJpeg;
  errors.manager.emit_message = ReceiveJpegMessage;
  jpeg_create_decompress(&info);
  if (setjmp(errors.failure)) {
    jpeg_destroy_decompress(&info);
    return false;
  }
  jpeg_mem_src(&info, reinterpret_cast<const uint8_t*>(bytes.data()),
               static_cast<unsigned long>(bytes.size()));
  jpeg_read_header(&info, TRUE);
  if (info.num_components != 1 && info.num_components != 3)
    FailJpeg(reinterpret_cast<j_common_ptr>(&info));
  const int type = TypeFor(conversion, info.num_components, 8);
  info.out_color_space = CV_MAT_CN(type) == 1 ? JCS_GRAYSCALE : JCS_EXT_BGR;
  pixels->create(static_cast<int>(info.image_height),
                 static_cast<int>(info.image_width), type);
  jpeg_start_decompress(&info);
  while (info.output_scanline < info.output_height) {
    JSAMPROW row = pixels->ptr(static_cast<int>(info.output_scanline));
    jpeg_read_scanlines(&info, &row, 1);
  }
  jpeg_finish_decompress(&info);
  jpeg_destroy_decompress(&info);
  return true;
}

bool EncodeJpegFile(const cv::Mat& pixels, int quality, uint8_t** bytes,
                    unsigned long* size) {
  jpeg_compress_struct info;
  JpegErrors errors;
  info.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = FailJpeg;
  jpeg_create_compress(&info);
  if (setjmp(errors.failure)) {
    jpeg_destroy_compress(&info);
    return false;
  }
  jpeg_mem_dest(&info, bytes, size);
  info.image_width = static_cast<JDIMENSION>(pixels.cols);
  info.image_height = static_cast<JDIMENSION>(pixels.rows);
  info.input_components = 1;
  info.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, quality, TRUE);
  jpeg_start_compress(&info, TRUE);
  while (info.next_scanline < info.image_height) {
    JSAMPROW row =
        const_cast<uint8_t*>(pixels.ptr(static_cast<int>(info.next_scanline)));
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  return true;
}

}  // namespace

cv::Mat DecodeJpeg(const std::string& bytes, PixelConversion conversion) {
  cv::Mat pixels;
  return DecodeJpegFile(bytes, conversion, &pixels) ? pixels : cv::Mat();
}

std::string EncodeJpeg(const cv::Mat& grey, int quality) {
  uint8_t* bytes = nullptr;
  unsigned long size = 0;
  const bool is_done = EncodeJpegFile(grey, quality, &bytes, &size);
  std::string encoded;
  if (is_done) encoded.assign(reinterpret_cast<const char*>(bytes), size);
  std::free(bytes);
  if (!is_done) throw std::logic_error("JPEG: cannot encode this image");
  return encoded;
}

}  // namespace raygrid
