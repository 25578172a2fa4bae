#include <png.h>

#include <csetjmp>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "dataset/pixel_conversion.h"

namespace raygrid {
namespace {

// On errors, libpng leaves its functions by longjmp(). Functions that call
// setjmp() therefore have no local variables with destructors.

struct PngInput {
  const std::string* bytes;
  size_t position;
};

// Error handlers; libpng's default ones print messages.
[[noreturn]] void LeavePng(png_structp png, png_const_charp) {
  png_longjmp(png, 1);
}

void IgnorePngWarning(png_structp, png_const_charp) {}

void ReadPng(png_structp png, png_bytep data, size_t size) {
  auto* input = static_cast<PngInput*>(png_get_io_ptr(png));
  if (size > input->bytes->size() - input->position)
    png_error(png, "Not enough data");
  std::memcpy(data, input->bytes->data() + input->position, size);
  input->position += size;
}

bool DecodePngFile(const std::string& bytes, PixelConversion conversion,
                   cv::Mat* pixels, std::vector<png_bytep>* rows) {
  PngInput input = {&bytes, 0};
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr,
                                           LeavePng, IgnorePngWarning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  if (!info || setjmp(png_jmpbuf(png))) {
    png_destroy_read_struct(&png, &info, nullptr);
    return false;
  }
  png_set_read_fn(png, &input, ReadPng);
  png_read_info(png, info);
  const int color = png_get_color_type(png, info);
  const bool has_colors = (color & PNG_COLOR_MASK_COLOR) != 0;
  const bool has_alpha = (color & PNG_COLOR_MASK_ALPHA) != 0 ||
                         png_get_valid(png, info, PNG_INFO_tRNS) != 0;
  const int bits = png_get_bit_depth(png, info);
  const int channels = has_alpha ? 4 : (has_colors ? 3 : 1);
  const int type = TypeFor(conversion, channels, bits);
  const bool wants_colors = CV_MAT_CN(type) > 1;
  if (CV_MAT_DEPTH(type) == CV_8U) png_set_strip_16(png);
  if (CV_MAT_DEPTH(type) == CV_16U && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__)
    png_set_swap(png);
  if (CV_MAT_CN(type) < 4)
    png_set_strip_alpha(png);
  else
    png_set_tRNS_to_alpha(png);
  if (color == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
  if (!has_colors && bits < 8) png_set_expand_gray_1_2_4_to_8(png);
  if (has_colors && wants_colors)
    png_set_bgr(png);
  else if (wants_colors)
    png_set_gray_to_rgb(png);
  else
    png_set_rgb_to_gray(png, 1, 0.299, 0.587);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  pixels->create(static_cast<int>(png_get_image_height(png, info)),
                 static_cast<int>(png_get_image_width(png, info)), type);
  if (png_get_rowbytes(png, info) != pixels->cols * pixels->elemSize())
    png_error(png, "Unknown layout");
  rows->resize(pixels->rows);
  for (int y = 0; y < pixels->rows; ++y) (*rows)[y] = pixels->ptr(y);
  png_read_image(png, rows->data());
  png_read_end(png, nullptr);
  png_destroy_read_struct(&png, &info, nullptr);
  return true;
}

void AppendPng(png_structp png, png_bytep data, size_t size) {
  static_cast<std::string*>(png_get_io_ptr(png))
      ->append(reinterpret_cast<const char*>(data), size);
}

void FlushPng(png_structp) {}

// Encodes like cv::imencode(), favouring speed over size.
bool EncodePngFile(const cv::Mat& pixels, std::string* bytes,
                   std::vector<png_bytep>* rows) {
  constexpr int kFastest = 1, kRunLengths = 3;  // zlib's level and strategy
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr,
                                            LeavePng, IgnorePngWarning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  if (!info || setjmp(png_jmpbuf(png))) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, bytes, AppendPng, FlushPng);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  png_set_compression_level(png, kFastest);
  png_set_compression_strategy(png, kRunLengths);
  const int channels = pixels.channels();
  png_set_IHDR(png, info, static_cast<uint32_t>(pixels.cols),
               static_cast<uint32_t>(pixels.rows),
               pixels.depth() == CV_8U ? 8 : 16,
               channels == 1   ? PNG_COLOR_TYPE_GRAY
               : channels == 3 ? PNG_COLOR_TYPE_RGB
                               : PNG_COLOR_TYPE_RGBA,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  png_set_bgr(png);
  if (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__) png_set_swap(png);
  rows->resize(pixels.rows);
  for (int y = 0; y < pixels.rows; ++y)
    (*rows)[y] = const_cast<png_bytep>(pixels.ptr(y));
  png_write_image(png, rows->data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return true;
}

}  // namespace

cv::Mat DecodePng(const std::string& bytes, PixelConversion conversion) {
  cv::Mat pixels;
  std::vector<png_bytep> rows;
  return DecodePngFile(bytes, conversion, &pixels, &rows) ? pixels : cv::Mat();
}

std::string EncodePng(const cv::Mat& pixels) {
  std::string encoded;
  std::vector<png_bytep> rows;
  if (!EncodePngFile(pixels, &encoded, &rows))
    throw std::logic_error("PNG: cannot encode this kind of pixels");
  return encoded;
}

}  // namespace raygrid
