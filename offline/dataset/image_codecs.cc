// jpeglib.h requires the types of stdio.h.
#include <cstdio>
// It has to come first.
#include <jpeglib.h>
// It needs jpeglib.h.
#include <jerror.h>
#include <png.h>
#include <webp/decode.h>

#include <algorithm>
#include <cctype>
#include <csetjmp>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
// It has names of OpenCV, too.
#include <tiffio.h>

#include "dataset/image_codecs.h"

namespace raygrid {
namespace {

// Libraries of C jump out of a call that fails. A function that calls setjmp()
// has nothing to destroy.

bool Keeps16Bits(PixelConversion conversion) {
  return conversion == PixelConversion::kNone ||
         conversion == PixelConversion::kGreyAnyDepth;
}

int TypeFor(PixelConversion conversion, int channels, int bits) {
  if (conversion == PixelConversion::kColor)
    channels = 3;
  else if (conversion != PixelConversion::kNone)
    channels = 1;
  const bool is_wide = bits == 16 && Keeps16Bits(conversion);
  return CV_MAKETYPE(is_wide ? CV_16U : CV_8U, channels);
}

// Fixed-point weights as in OpenCV's codecs; for WebP, OpenCV converts
// elsewhere, with one more bit.
struct GreyWeights {
  int blue, green, red, bits;
};
constexpr GreyWeights kGreyOfCodecs = {1868, 9617, 4899, 14};
constexpr GreyWeights kGreyOfWebp = {3735, 19235, 9798, 15};

template <typename From, typename To>
void ConvertRow(const From* from, int from_channels, const GreyWeights& weights,
                int width, To* to, int to_channels) {
  constexpr int kShift = 8 * (sizeof(From) - sizeof(To));
  for (int x = 0; x < width; ++x) {
    const From* pixel = from + x * from_channels;
    if (to_channels == 1 && from_channels > 1) {
      const int64_t sum = int64_t(weights.blue) * (pixel[0] >> kShift) +
                          weights.green * (pixel[1] >> kShift) +
                          weights.red * (pixel[2] >> kShift);
      to[x] =
          static_cast<To>((sum + (1 << (weights.bits - 1))) >> weights.bits);
      continue;
    }
    for (int c = 0; c < to_channels; ++c)
      to[x * to_channels + c] =
          static_cast<To>(pixel[from_channels == 1 ? 0 : c] >> kShift);
  }
}

// Converts the pixels of a file. Colours are BGR or BGRA.
cv::Mat Converted(const cv::Mat& stored, PixelConversion conversion,
                  const GreyWeights& weights = kGreyOfCodecs) {
  const int bits = stored.depth() == CV_16U ? 16 : 8;
  const int type = TypeFor(conversion, stored.channels(), bits);
  if (type == stored.type()) return stored;
  cv::Mat result(stored.size(), type);
  for (int y = 0; y < stored.rows; ++y) {
    const int from = stored.channels(), to = result.channels();
    if (bits == 8)
      ConvertRow(stored.ptr(y), from, weights, stored.cols, result.ptr(y), to);
    else if (result.depth() == CV_8U)
      ConvertRow(stored.ptr<uint16_t>(y), from, weights, stored.cols,
                 result.ptr(y), to);
    else
      ConvertRow(stored.ptr<uint16_t>(y), from, weights, stored.cols,
                 result.ptr<uint16_t>(y), to);
  }
  return result;
}

// ---- JPEG

struct JpegErrors {
  jpeg_error_mgr manager;
  jmp_buf failure;
};

// libjpeg fills in missing data, with only a warning.
bool IsDamage(int warning) {
  return warning == JWRN_ARITH_BAD_CODE || warning == JWRN_EXTRANEOUS_DATA ||
         warning == JWRN_HIT_MARKER || warning == JWRN_HUFF_BAD_CODE ||
         warning == JWRN_JPEG_EOF || warning == JWRN_MUST_RESYNC;
}

void FailJpeg(j_common_ptr info) {
  longjmp(reinterpret_cast<JpegErrors*>(info->err)->failure, 1);
}

// Levels from 0 on are trace messages.
void ReceiveJpegMessage(j_common_ptr info, int level) {
  if (level < 0 && IsDamage(info->err->msg_code)) FailJpeg(info);
}

bool DecodeJpeg(const std::string& bytes, PixelConversion conversion,
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

// ---- PNG

struct PngInput {
  const std::string* bytes;
  size_t position;
};

// Without them, libpng prints lines of its own.
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

bool DecodePng(const std::string& bytes, PixelConversion conversion,
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

// The bytes of cv::imencode(): fast rather than small.
bool EncodePngFile(const cv::Mat& pixels, std::string* bytes,
                   std::vector<png_bytep>* rows) {
  constexpr int kFastest = 1, kRunLengths = 3;  // of zlib
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

// ---- TIFF

struct TiffInput {
  const std::string* bytes;
  uint64_t position;
};

tmsize_t ReadTiff(thandle_t handle, void* data, tmsize_t size) {
  auto* input = static_cast<TiffInput*>(handle);
  const uint64_t all = input->bytes->size();
  const uint64_t left = all - std::min(all, input->position);
  const uint64_t count = std::min<uint64_t>(left, static_cast<uint64_t>(size));
  std::memcpy(data, input->bytes->data() + input->position, count);
  input->position += count;
  return static_cast<tmsize_t>(count);
}

tmsize_t WriteNoTiff(thandle_t, void*, tmsize_t) { return 0; }

uint64_t SeekTiff(thandle_t handle, uint64_t offset, int whence) {
  auto* input = static_cast<TiffInput*>(handle);
  if (whence == SEEK_CUR) offset += input->position;
  if (whence == SEEK_END) offset += input->bytes->size();
  return input->position = offset;
}

int CloseTiff(thandle_t) { return 0; }

uint64_t SizeOfTiff(thandle_t handle) {
  return static_cast<TiffInput*>(handle)->bytes->size();
}

// Calls return that they failed.
int IgnoreTiffMessage(TIFF*, void*, const char*, const char*, va_list) {
  return 1;
}

// Converts red, green, blue to blue, green, red.
void SwapRedAndBlue(cv::Mat* pixels) {
  const int channels = pixels->channels();
  for (int y = 0; y < pixels->rows; ++y)
    for (int x = 0; x < pixels->cols; ++x) {
      if (pixels->depth() == CV_16U) {
        uint16_t* pixel = pixels->ptr<uint16_t>(y) + x * channels;
        std::swap(pixel[0], pixel[2]);
      } else {
        uint8_t* pixel = pixels->ptr(y) + x * channels;
        std::swap(pixel[0], pixel[2]);
      }
    }
}

// Reads 16-bit samples as stored in the file.
bool ReadWideTiff(TIFF* tiff, cv::Mat* pixels) {
  if (!TIFFIsTiled(tiff)) {
    std::vector<uint8_t> row(static_cast<size_t>(TIFFScanlineSize(tiff)));
    const size_t wanted = pixels->cols * pixels->elemSize();
    if (row.size() < wanted) return false;
    for (int y = 0; y < pixels->rows; ++y) {
      if (TIFFReadScanline(tiff, row.data(), static_cast<uint32_t>(y), 0) < 0)
        return false;
      std::memcpy(pixels->ptr(y), row.data(), wanted);
    }
    return true;
  }
  uint32_t width = 0, height = 0;
  TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &width);
  TIFFGetField(tiff, TIFFTAG_TILELENGTH, &height);
  std::vector<uint8_t> tile(static_cast<size_t>(TIFFTileSize(tiff)));
  const size_t row_bytes = static_cast<size_t>(TIFFTileRowSize(tiff));
  if (width == 0 || height == 0 || row_bytes < width * pixels->elemSize() ||
      tile.size() < height * row_bytes)
    return false;
  const int step_x = static_cast<int>(width), step_y = static_cast<int>(height);
  for (int top = 0; top < pixels->rows; top += step_y)
    for (int left = 0; left < pixels->cols; left += step_x) {
      if (TIFFReadTile(tiff, tile.data(), static_cast<uint32_t>(left),
                       static_cast<uint32_t>(top), 0, 0) < 0)
        return false;
      const int columns = std::min(step_x, pixels->cols - left);
      for (int y = 0; y < std::min(step_y, pixels->rows - top); ++y)
        std::memcpy(pixels->ptr(top + y) + left * pixels->elemSize(),
                    tile.data() + y * row_bytes, columns * pixels->elemSize());
    }
  return true;
}

// Reads any file as 8 bits: libtiff converts it to RGBA.
bool ReadNarrowTiff(TIFF* tiff, int channels, cv::Mat* pixels) {
  std::vector<uint32_t> raster(pixels->total());
  if (!TIFFReadRGBAImageOriented(tiff, static_cast<uint32_t>(pixels->cols),
                                 static_cast<uint32_t>(pixels->rows),
                                 raster.data(), ORIENTATION_TOPLEFT, 1))
    return false;
  const uint32_t* from = raster.data();
  for (int y = 0; y < pixels->rows; ++y)
    for (int x = 0; x < pixels->cols; ++x, ++from) {
      const uint32_t value = *from;
      const uint8_t bgra[4] = {
          uint8_t(TIFFGetB(value)), uint8_t(TIFFGetG(value)),
          uint8_t(TIFFGetR(value)), uint8_t(TIFFGetA(value))};
      std::memcpy(pixels->ptr(y) + x * channels, bgra, channels);
    }
  return true;
}

cv::Mat ReadOpenTiff(TIFF* tiff, PixelConversion conversion) {
  uint32_t width = 0, height = 0;
  uint16_t bits = 1, channels = 1, format = SAMPLEFORMAT_UINT, planar = 1;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &channels);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planar);
  const int rows = static_cast<int>(height), columns = static_cast<int>(width);
  if (rows <= 0 || columns <= 0) return {};
  if (bits > 16 || format != SAMPLEFORMAT_UINT)
    return cv::Mat(rows, columns, CV_32F);  // rejected with its name
  if (bits == 16 && Keeps16Bits(conversion)) {
    if ((channels != 1 && channels != 3 && channels != 4) ||
        (channels > 1 && planar != PLANARCONFIG_CONTIG))
      return {};
    cv::Mat pixels(rows, columns, CV_MAKETYPE(CV_16U, channels));
    if (!ReadWideTiff(tiff, &pixels)) return {};
    if (channels > 1) SwapRedAndBlue(&pixels);
    return Converted(pixels, conversion);
  }
  const int kept = channels == 1   ? 3
                   : channels == 2 ? 4
                                   : std::min<int>(channels, 4);
  uint16_t photometric = PHOTOMETRIC_MINISBLACK;
  TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
  const bool is_grey = channels == 1 && photometric != PHOTOMETRIC_PALETTE;
  cv::Mat pixels(rows, columns, CV_MAKETYPE(CV_8U, kept));
  if (!ReadNarrowTiff(tiff, kept, &pixels)) return {};
  if (!is_grey) return Converted(pixels, conversion);
  // Grey has three equal channels.
  cv::Mat grey(rows, columns, CV_8U);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) grey.ptr(y)[x] = pixels.ptr(y)[kept * x];
  return Converted(grey, conversion);
}

cv::Mat DecodeTiff(const std::string& bytes, PixelConversion conversion) {
  TiffInput input = {&bytes, 0};
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  TIFFOpenOptionsSetErrorHandlerExtR(options, IgnoreTiffMessage, nullptr);
  TIFFOpenOptionsSetWarningHandlerExtR(options, IgnoreTiffMessage, nullptr);
  TIFF* tiff =
      TIFFClientOpenExt("image", "rm", &input, ReadTiff, WriteNoTiff, SeekTiff,
                        CloseTiff, SizeOfTiff, nullptr, nullptr, options);
  TIFFOpenOptionsFree(options);
  if (!tiff) return {};
  cv::Mat pixels;
  try {
    pixels = ReadOpenTiff(tiff, conversion);
  } catch (...) {
    TIFFClose(tiff);
    throw;
  }
  TIFFClose(tiff);
  return pixels;
}

// ---- WebP

cv::Mat DecodeWebp(const std::string& bytes, PixelConversion conversion) {
  const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(data, bytes.size(), &features) != VP8_STATUS_OK)
    return {};
  const int channels =
      features.has_alpha && conversion == PixelConversion::kNone ? 4 : 3;
  cv::Mat pixels(features.height, features.width, CV_MAKETYPE(CV_8U, channels));
  const size_t size = pixels.total() * pixels.elemSize();
  const int stride = static_cast<int>(pixels.step);
  const uint8_t* done =
      channels == 4
          ? WebPDecodeBGRAInto(data, bytes.size(), pixels.data, size, stride)
          : WebPDecodeBGRInto(data, bytes.size(), pixels.data, size, stride);
  return done ? Converted(pixels, conversion, kGreyOfWebp) : cv::Mat();
}

// ---- PGM and PPM

// The next number of a header or of a text file; -1 if there is none.
int NextNumber(const std::string& bytes, size_t* position) {
  size_t& at = *position;
  while (at < bytes.size() &&
         (std::isspace(uint8_t(bytes[at])) || bytes[at] == '#'))
    at = bytes[at] == '#' ? std::min(bytes.find('\n', at), bytes.size())
                          : at + 1;
  int value = -1;
  for (; at < bytes.size() && std::isdigit(uint8_t(bytes[at])); ++at) {
    value = std::max(value, 0) * 10 + (bytes[at] - '0');
    if (value > 1 << 20) return -1;
  }
  return value;
}

cv::Mat DecodePnm(const std::string& bytes, PixelConversion conversion) {
  const bool is_text = bytes[1] < '4';
  const int channels = bytes[1] == '3' || bytes[1] == '6' ? 3 : 1;
  size_t at = 2;
  const int columns = NextNumber(bytes, &at), rows = NextNumber(bytes, &at);
  const int most = NextNumber(bytes, &at);
  if (columns <= 0 || rows <= 0 || most <= 0 || most > 65535) return {};
  const bool is_wide = most > 255;
  cv::Mat pixels(rows, columns,
                 CV_MAKETYPE(is_wide ? CV_16U : CV_8U, channels));
  const size_t count = pixels.total() * channels;
  ++at;  // one space ends the header
  if (!is_text &&
      bytes.size() - std::min(at, bytes.size()) < count * (is_wide ? 2 : 1))
    return {};
  for (size_t i = 0; i < count; ++i) {
    int value = 0;
    if (is_text) {
      value = NextNumber(bytes, &at);
      if (value < 0 || value > most) return {};
    } else {
      value = uint8_t(bytes[at++]);
      if (is_wide) value = value << 8 | uint8_t(bytes[at++]);
    }
    if (is_wide)
      reinterpret_cast<uint16_t*>(pixels.data)[i] =
          static_cast<uint16_t>(value);
    else
      pixels.data[i] = static_cast<uint8_t>(value);
  }
  if (channels > 1) SwapRedAndBlue(&pixels);
  return Converted(pixels, conversion);
}

// ---- BMP, only the common variants without compression

uint32_t Little(const std::string& bytes, size_t at, int count) {
  uint32_t value = 0;
  for (int i = count - 1; i >= 0; --i)
    value = value << 8 | uint8_t(bytes[at + i]);
  return value;
}

cv::Mat DecodeBmp(const std::string& bytes, PixelConversion conversion) {
  constexpr size_t kHeaders = 54;
  if (bytes.size() < kHeaders || Little(bytes, 14, 4) < 40) return {};
  const size_t begin = Little(bytes, 10, 4),
               palette = 14 + Little(bytes, 14, 4);
  const int columns = static_cast<int32_t>(Little(bytes, 18, 4));
  const int64_t signed_rows = static_cast<int32_t>(Little(bytes, 22, 4));
  const int64_t rows = std::abs(signed_rows);
  const uint32_t bits = Little(bytes, 28, 2),
                 compression = Little(bytes, 30, 4);
  if (columns <= 0 || rows == 0 || (bits != 8 && bits != 24 && bits != 32) ||
      compression != 0)
    return {};
  const size_t stride = (size_t(columns) * bits / 8 + 3) / 4 * 4;
  if (begin > bytes.size() || bytes.size() - begin < stride * rows) return {};
  size_t num_colors = Little(bytes, 46, 4);
  if (num_colors == 0) num_colors = 256;
  if (bits == 8 &&
      (num_colors > 256 || palette > begin || begin - palette < 4 * num_colors))
    return {};
  bool is_grey = bits == 8;
  for (size_t i = 0; is_grey && i < num_colors; ++i) {
    const char* color = bytes.data() + palette + 4 * i;
    is_grey = color[0] == color[1] && color[1] == color[2];
  }
  cv::Mat pixels(static_cast<int>(rows), columns, is_grey ? CV_8UC1 : CV_8UC3);
  for (int y = 0; y < rows; ++y) {
    const char* from =
        bytes.data() + begin + stride * (signed_rows > 0 ? rows - 1 - y : y);
    for (int x = 0; x < columns; ++x) {
      const char* color = from + size_t(x) * bits / 8;
      if (bits == 8) {
        const size_t index = uint8_t(*color);
        if (index >= num_colors) return {};
        color = bytes.data() + palette + 4 * index;
      }
      std::memcpy(pixels.ptr(y) + x * pixels.channels(), color,
                  pixels.channels());
    }
  }
  return Converted(pixels, conversion);
}

bool BeginsWith(const std::string& bytes, const std::string& magic,
                size_t at = 0) {
  return bytes.compare(at, magic.size(), magic) == 0;
}

}  // namespace

cv::Mat DecodeImage(const std::string& bytes, PixelConversion conversion) {
  if (bytes.size() < 12) return {};
  cv::Mat pixels;
  std::vector<png_bytep> rows;
  if (BeginsWith(bytes, "\xff\xd8\xff"))
    return DecodeJpeg(bytes, conversion, &pixels) ? pixels : cv::Mat();
  if (BeginsWith(bytes, "\x89PNG"))
    return DecodePng(bytes, conversion, &pixels, &rows) ? pixels : cv::Mat();
  if (BeginsWith(bytes, {'I', 'I', '*', '\0'}) ||
      BeginsWith(bytes, {'M', 'M', '\0', '*'}))
    return DecodeTiff(bytes, conversion);
  if (BeginsWith(bytes, "RIFF") && BeginsWith(bytes, "WEBP", 8))
    return DecodeWebp(bytes, conversion);
  if (bytes[0] == 'P' && std::strchr("2356", bytes[1]) && bytes[1])
    return DecodePnm(bytes, conversion);
  if (BeginsWith(bytes, "BM")) return DecodeBmp(bytes, conversion);
  return {};
}

std::string EncodePng(const cv::Mat& pixels) {
  std::string encoded;
  std::vector<png_bytep> rows;
  if (!EncodePngFile(pixels, &encoded, &rows))
    throw std::logic_error("PNG: cannot encode this kind of pixels");
  return encoded;
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
