#ifndef RAYGRID_DATASET_PIXEL_CONVERSION_H
#define RAYGRID_DATASET_PIXEL_CONVERSION_H

#include "dataset/image_codecs.h"

namespace raygrid {

bool Keeps16Bits(PixelConversion conversion);

/// Returns OpenCV's type of the converted pixels of a file.
int TypeFor(PixelConversion conversion, int channels, int bits);

/// Fixed-point weights as in OpenCV's codecs; for WebP, OpenCV converts
/// elsewhere, with one more bit.
struct GreyWeights {
  int blue, green, red, bits;
};
constexpr GreyWeights kCodecGreyWeights = {1868, 9617, 4899, 14};
constexpr GreyWeights kWebpGreyWeights = {3735, 19235, 9798, 15};

/// Converts the pixels of a file. Colours are BGR or BGRA.
cv::Mat Converted(const cv::Mat& stored, PixelConversion conversion,
                  const GreyWeights& weights = kCodecGreyWeights);

/// Converts red, green, blue to blue, green, red.
void SwapRedAndBlue(cv::Mat* pixels);

// Decoders of DecodeImage() for single formats.
cv::Mat DecodeJpeg(const std::string& bytes, PixelConversion conversion);
cv::Mat DecodePng(const std::string& bytes, PixelConversion conversion);
cv::Mat DecodeTiff(const std::string& bytes, PixelConversion conversion);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_PIXEL_CONVERSION_H
