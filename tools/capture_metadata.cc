#include "capture_metadata.h"

#include <fmt/format.h>

#include <algorithm>

#include "dataset/error.h"
#include "dataset/image_times.h"
#include "dataset/text_encoding.h"
#include "operating_point_input.h"

namespace raygrid {
namespace {

// Returns the timestamps of each camera's images, if the line delay is to be
// estimated.
std::vector<std::optional<ImageTimes>> CollectTimes(
    const CalibrateArguments& arguments,
    const std::vector<Measurements>& cameras) {
  std::vector<std::optional<ImageTimes>> times(cameras.size());
  if (!arguments.rolling_shutter) return times;
  const ImageTimes given =
      arguments.times.empty() ? ImageTimes() : ReadImageTimes(arguments.times);
  for (size_t c = 0; c < cameras.size(); ++c) {
    times[c] = c < arguments.session_times.size() && given.empty()
                   ? arguments.session_times[c]
                   : given;
    const std::vector<ImageFeatures>& images = cameras[c].dataset.images;
    if (std::none_of(images.begin(), images.end(),
                     [&](const ImageFeatures& image) {
                       return times[c]->count(image.image) > 0;
                     }))
      throw InputError(fmt::format(
          "{}: lacks timestamps of images, such as {}",
          arguments.times.empty() ? "the session" : arguments.times,
          images.empty() ? "none" : Printable(images.front().image)));
  }
  return times;
}

}  // namespace

CaptureMetadata ReadCaptureMetadata(const CalibrateArguments& arguments,
                                    const std::vector<Measurements>& cameras) {
  return {CollectTimes(arguments, cameras),
          ReadOperatingPoints(arguments, cameras.front())};
}

}  // namespace raygrid
