#include "packing/distorted_image.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

// Bilinear interpolation of an image with one sample type.
template <typename Sample>
class BilinearImage {
 public:
  explicit BilinearImage(const Image& picture) : image_(picture) {}

  // Writes the channels at a position between the centres of the first and the
  // last pixel.
  void Sampled(const Eigen::Vector2d& position, uint8_t* to) const {
    const int x0 = GetFirstIndex(position.x(), image_.size.width);
    const int y0 = GetFirstIndex(position.y(), image_.size.height);
    const int x1 = std::min(x0 + 1, image_.size.width - 1);
    const int y1 = std::min(y0 + 1, image_.size.height - 1);
    const double u = position.x() - x0, v = position.y() - y0;
    for (int c = 0; c < image_.channels; ++c) {
      const double value =
          (1 - v) * ((1 - u) * At(x0, y0, c) + u * At(x1, y0, c)) +
          v * ((1 - u) * At(x0, y1, c) + u * At(x1, y1, c));
      const Sample rounded = static_cast<Sample>(std::lround(value));
      std::memcpy(to + c * sizeof(Sample), &rounded, sizeof(Sample));
    }
  }

 private:
  static int GetFirstIndex(double coordinate, int num_pixels) {
    return std::clamp(static_cast<int>(coordinate), 0,
                      std::max(0, num_pixels - 2));
  }
  double At(int x, int y, int c) const {
    Sample sample;
    std::memcpy(&sample,
                &image_.pixels[y * image_.stride() +
                               (static_cast<size_t>(x) * image_.channels + c) *
                                   sizeof(Sample)],
                sizeof(Sample));
    return sample;
  }

  const Image& image_;
};

template <typename Sample>
void Distort(const SourceMap& map, const Image& picture, int num_threads,
             Image* result) {
  const BilinearImage<Sample> bilinear(picture);
  const size_t pixel_bytes = picture.channels * sizeof(Sample);
  ParallelFor(map.height, num_threads, [&](int y) {
    uint8_t* to = &result->pixels[y * result->stride()];
    for (int x = 0; x < map.width; ++x, to += pixel_bytes) {
      if (!map.IsKnown(x, y)) continue;
      const Eigen::Vector2d source = map.At(x, y);
      if (map.IsInside(source))
        bilinear.Sampled(
            {std::clamp(source.x(), map.rectangle.x0, map.rectangle.x1),
             std::clamp(source.y(), map.rectangle.y0, map.rectangle.y1)},
            to);
    }
  });
}

}  // namespace

SourceMap MakeDistortionMap(const CameraModel& camera, const VirtualView& view,
                            int num_threads) {
  SourceMap map =
      MakeSourceMap(*MakeRotatedViewCamera(view), MakeCameraOutput(camera),
                    NumThreads(num_threads));
  if (!camera.image_circle()) return map;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      if (!camera.IsInImageCircle(Eigen::Vector2d(x, y)))
        map.sources[0][map.Index(x, y)] = SourceMap::kUnknown;
  return map;
}

Image DistortImage(const SourceMap& map, const Image& picture,
                   int num_threads) {
  Image result;
  result.size = {map.width, map.height};
  result.channels = picture.channels;
  result.sample_bytes = picture.sample_bytes;
  result.pixels.assign(result.stride() * result.size.height, 0);
  if (picture.sample_bytes == 1)
    Distort<uint8_t>(map, picture, NumThreads(num_threads), &result);
  else
    Distort<uint16_t>(map, picture, NumThreads(num_threads), &result);
  return result;
}

}  // namespace raygrid
