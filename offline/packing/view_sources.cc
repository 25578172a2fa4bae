#include "packing/view_sources.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "camera/central_generic.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "packing/source_map.h"

namespace raygrid {
namespace {

// Returns the exact source of every pixel of an output image.
std::vector<Eigen::Vector2d> ExactSources(const CameraModel& camera,
                                          const OutputImage& output,
                                          int num_threads) {
  // The tolerance for a source at the image's edge, due to rounding.
  constexpr double kEdgeRoundingPx = 1e-6;
  num_threads = NumThreads(num_threads);
  const SourceMap map = MakeSourceMap(camera, output, num_threads);
  std::vector<Eigen::Vector2d> sources(
      static_cast<size_t>(map.width) * map.height, Eigen::Vector2d(NAN, NAN));
  ParallelFor(map.height, num_threads, [&](int y) {
    for (int x = 0; x < map.width; ++x) {
      if (!map.IsKnown(x, y)) continue;
      const auto source = ExactSource(camera, output, map, x, y);
      if (source && map.rectangle.Contains(*source, kEdgeRoundingPx))
        sources[static_cast<size_t>(y) * map.width + x] = *source;
    }
  });
  return sources;
}

// Excludes the camera's pixels outside the image circle.
void ExcludeOutsideImageCircle(const CameraModel& camera, bool is_reverse,
                               ViewSources* view) {
  for (size_t k = 0; k < view->sources.size(); ++k) {
    const int x = static_cast<int>(k) % view->size.width,
              y = static_cast<int>(k) / view->size.width;
    if (!camera.IsInImageCircle(is_reverse ? Eigen::Vector2d(x, y)
                                           : view->sources[k]))
      view->sources[k].setConstant(NAN);
  }
}

}  // namespace

std::unique_ptr<CameraModel> CentralCamera(const CameraModel& camera) {
  if (camera.IsCentral()) return camera.Clone();
  if (!camera.DirectionGrid())
    throw Error(ExitCode::kUsage,
                fmt::format("its model is non-central; convert it to {} or a "
                            "central model first",
                            models::kNonCentralGeneric));
  return MakeCentral(camera).Clone();
}

ViewSources MakeViewSources(const CameraModel& lines, const VirtualView& view,
                            bool is_reverse, int num_threads) {
  const auto camera = CentralCamera(lines);
  ViewSources result;
  result.size = view.size;
  result.source_size = camera->image_size();
  if (is_reverse) std::swap(result.size, result.source_size);
  result.sources =
      is_reverse ? ExactSources(*MakeRotatedViewCamera(view),
                                MakeCameraOutput(*camera), num_threads)
                 : ExactSources(*camera, MakeViewOutput(view), num_threads);
  ExcludeOutsideImageCircle(*camera, is_reverse, &result);
  return result;
}

}  // namespace raygrid
