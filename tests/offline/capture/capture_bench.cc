// Times what a live capture does with each frame: detection, the frame's
// quality, its word. The camera is adjusted beside that, and is not counted.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "capture/board_view.h"
#include "capture/capture_guide.h"
#include "capture/keyframe_selector.h"
#include "features/pattern_detector.h"
#include "simulation/board_surface.h"
#include "simulation/image_rendering.h"
#include "simulation/simulated_camera_models.h"
#include "target/board_spec.h"

namespace raygrid {
namespace {

constexpr int kNumViews = 12, kNumRounds = 5;

// Views all over the image, near and far.
std::vector<GreyImage> RenderViews(const CameraModel& camera,
                                   const Board& board) {
  const BoardSurface surface(board);
  const PixelRays rays(camera, 1);
  const ImageSize size = camera.image_size();
  std::vector<GreyImage> images;
  for (int i = 0; i < kNumViews; ++i) {
    const BoardView view = {{size.width * (0.25 + 0.25 * (i % 3)),
                             size.height * (0.35 + 0.15 * (i / 3 % 3))},
                            size.width * (0.4 + 0.04 * i),
                            0.5,
                            1.1 * i,
                            0.2 * i};
    const auto pose = ComputePose(view, board, camera);
    if (!pose) continue;
    ImagingOptions imaging;
    imaging.read_noise = 2;
    imaging.seed = i;
    images.push_back(MakeGreyImage(AddNoiseAndQuantize(
        RenderImage(rays, {{&surface, *pose}}, imaging, 1), imaging)));
  }
  return images;
}

void Time(const std::string& spec, const std::string& lens,
          const ImageSize& size) {
  const Pattern pattern = ReadPatternOrSpec(spec);
  const auto camera = MakeSimulatedCamera(lens, size);
  const std::vector<GreyImage> images =
      RenderViews(*camera, pattern.boards.front());
  const PatternDetector detector(pattern, {});
  const QualityMeter meter(pattern.boards.front());
  LiveCamera live(pattern, size, 1);
  std::vector<ImageFeatures> seen;
  for (const GreyImage& image : images)
    seen.push_back(
        {std::to_string(seen.size()), detector.Detect(image).features});
  live.Add(seen);
  const CaptureGuide guide(live, pattern, {});
  KeyframeSelector judge({});
  std::vector<double> seconds;
  for (int round = 0; round < kNumRounds; ++round)
    for (const GreyImage& image : images) {
      const auto start = std::chrono::steady_clock::now();
      DetectedFrame frame;
      frame.features.features = detector.Detect(image).features;
      frame.quality =
          meter.Measure(image.size, image.levels, frame.features.features);
      judge.Assess(frame, guide);
      seconds.push_back(std::chrono::duration<double>(
                            std::chrono::steady_clock::now() - start)
                            .count());
    }
  std::sort(seconds.begin(), seconds.end());
  const double median = seconds[seconds.size() / 2];
  std::printf("%-32s %4d x %-4d  %6.1f frames/s  slowest %5.1f ms  %s\n",
              spec.c_str(), size.width, size.height, 1 / median,
              1e3 * seconds.back(),
              guide.information() ? "" : "camera unknown");
}

}  // namespace
}  // namespace raygrid

int main() {
  for (const char* spec : {"star:16x11:15mm", "charuco:9x6:25mm:marker=19mm",
                           "chessboard:9x6:25mm", "aprilgrid:6x6:24mm"}) {
    raygrid::Time(spec, "example", {640, 480});
    raygrid::Time(spec, "wide", {1280, 720});
  }
  return 0;
}
