#ifndef RAYGRID_DATASET_IMAGE_CODECS_H
#define RAYGRID_DATASET_IMAGE_CODECS_H

#include <opencv2/core.hpp>
#include <string>

namespace raygrid {

/// Conversions of decoded pixels; the values are cv::ImreadModes.
enum class PixelConversion {
  kNone = -1,        ///< channels, depth as in the file, BGR(A)
  kGrey = 0,         ///< 8 bits
  kColor = 1,        ///< BGR of 8 bits
  kGreyAnyDepth = 2  ///< 8 or 16 bits, as in the file
};

/// Decodes a PNG, JPEG, TIFF, WebP, PGM, PPM or BMP file, ignoring its
/// orientation, like cv::imdecode(). The image is empty for corrupt files and
/// unsupported variants (CMYK, compressed BMP); floating-point TIFF files yield
/// floats.
cv::Mat DecodeImage(const std::string& bytes, PixelConversion conversion);

/// Encodes 8 or 16 bits; 1 channel, BGR or BGRA.
std::string EncodePng(const cv::Mat& pixels);

/// Encodes 8-bit grey; quality is 0 to 100.
std::string EncodeJpeg(const cv::Mat& grey, int quality);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_IMAGE_CODECS_H
