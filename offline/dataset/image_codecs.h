#ifndef RAYGRID_DATASET_IMAGE_CODECS_H
#define RAYGRID_DATASET_IMAGE_CODECS_H

#include <opencv2/core.hpp>
#include <string>

namespace raygrid {

/// What decoded pixels are converted to; numbers are those of
/// cv::ImreadModes.
enum class PixelConversion {
  kNone = -1,        ///< channels and depth of the file, colours as BGR(A)
  kGrey = 0,         ///< 8 bits
  kColor = 1,        ///< BGR of 8 bits
  kGreyAnyDepth = 2  ///< 8 or 16 bits, as in the file
};

/// Decodes a PNG, JPEG, TIFF, WebP, PGM, PPM or BMP file without regard to its
/// orientation, to the pixels of cv::imdecode(). The image is empty if the
/// bytes are damaged, or of a variant that is not supported (CMYK, compressed
/// BMP); it has floats if a TIFF file has.
cv::Mat DecodeImage(const std::string& bytes, PixelConversion conversion);

/// Encodes 8 or 16 bits; 1 channel, BGR or BGRA.
std::string EncodePng(const cv::Mat& pixels);

/// Encodes 8 bits of grey; quality is 0 to 100.
std::string EncodeJpeg(const cv::Mat& grey, int quality);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_IMAGE_CODECS_H
