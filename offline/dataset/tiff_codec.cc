#include <algorithm>
#include <cstring>
#include <vector>
// tiffio.h must precede OpenCV's headers, which declare the same names.
#include <tiffio.h>

#include "dataset/pixel_conversion.h"

namespace raygrid {
namespace {

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

uint64_t GetTiffSize(thandle_t handle) {
  return static_cast<TiffInput*>(handle)->bytes->size();
}

// Suppresses messages; errors are reported by return values.
int IgnoreTiffMessage(TIFF*, void*, const char*, const char*, va_list) {
  return 1;
}

// Reads 16-bit samples as stored in the file.
bool Read16BitTiff(TIFF* tiff, cv::Mat* pixels) {
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

// Reads a file of any format as 8-bit samples: libtiff converts it to RGBA.
bool Read8BitTiff(TIFF* tiff, int channels, cv::Mat* pixels) {
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
    return cv::Mat(rows, columns, CV_32F);  // rejected by the caller, with its
                                            // name
  if (bits == 16 && Keeps16Bits(conversion)) {
    if ((channels != 1 && channels != 3 && channels != 4) ||
        (channels > 1 && planar != PLANARCONFIG_CONTIG))
      return {};
    cv::Mat pixels(rows, columns, CV_MAKETYPE(CV_16U, channels));
    if (!Read16BitTiff(tiff, &pixels)) return {};
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
  if (!Read8BitTiff(tiff, kept, &pixels)) return {};
  if (!is_grey) return Converted(pixels, conversion);
  // Grey images are decoded to three equal channels.
  cv::Mat grey(rows, columns, CV_8U);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) grey.ptr(y)[x] = pixels.ptr(y)[kept * x];
  return Converted(grey, conversion);
}

}  // namespace

cv::Mat DecodeTiff(const std::string& bytes, PixelConversion conversion) {
  TiffInput input = {&bytes, 0};
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  TIFFOpenOptionsSetErrorHandlerExtR(options, IgnoreTiffMessage, nullptr);
  TIFFOpenOptionsSetWarningHandlerExtR(options, IgnoreTiffMessage, nullptr);
  TIFF* tiff =
      TIFFClientOpenExt("image", "rm", &input, ReadTiff, WriteNoTiff, SeekTiff,
                        CloseTiff, GetTiffSize, nullptr, nullptr, options);
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

}  // namespace raygrid
