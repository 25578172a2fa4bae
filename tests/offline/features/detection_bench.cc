// Times the detection of a star board in one large image. Run by hand; with
// --once under valgrind --tool=callgrind
// --toggle-collect='raygrid::StarDetector::Detect*'.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "dataset/parallel_for.h"
#include "features/board_view/tag_detection.h"
#include "features/refinement/feature_refinement.h"
#include "features/star/star_detection.h"
#include "features/star/star_growth.h"
#include "simulation/image_rendering.h"
#include "simulation/simulated_camera_models.h"

namespace raygrid {
namespace {

constexpr ImageSize kSize = {1280, 800};

Pattern LargeBoard() {
  return ParsePattern(
      "pattern",
      "raygrid_pattern: 1\n"
      "boards:\n"
      "  - {id: 0, kind: star, columns: 24, rows: 16, square_m: 0.012, "
      "segments: 16, tags: [{family: tag36h11, id: 0, column: 10, row: 6, "
      "squares: 4}]}\n");
}

// Squares of about 40 px, all in the image.
GreyImage Photograph(const Board& board) {
  const auto camera = MakeSimulatedCamera("pinhole", kSize);
  const BoardSurface surface(board);
  Pose pose;
  pose.rotation =
      Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.3, 1, 0.1).normalized());
  pose.translation = Eigen::Vector3d(0, 0, 0.3) -
                     pose.rotation * Eigen::Vector3d(board.points.back() / 2);
  ImagingOptions options;
  options.read_noise = 2;
  options.seed = 1;
  const RenderedImage exact =
      RenderImage(PixelRays(*camera, 2), {{&surface, pose}}, options, 2);
  return MakeGreyImage(AddNoiseAndQuantize(exact, options));
}

double Milliseconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now() - start)
      .count();
}

// The median of seven runs after a first one.
double MedianMs(const std::function<void()>& work) {
  work();
  std::vector<double> times;
  for (int run = 0; run < 7; ++run) times.push_back(Milliseconds(work));
  std::nth_element(times.begin(), times.begin() + 3, times.end());
  return times[3];
}

void CornerSubpix(const GreyImage& image,
                  const std::vector<Feature>& features) {
  const cv::Mat grey(image.size.height, image.size.width, CV_8U,
                     const_cast<uint8_t*>(image.bytes.data()));
  std::vector<cv::Point2f> points;
  for (const Feature& feature : features)
    points.emplace_back(static_cast<float>(feature.pixel.x()),
                        static_cast<float>(feature.pixel.y()));
  cv::cornerSubPix(grey, points, {10, 10}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 1e-3});
}

// Growth from the tags, then refinement, as the detector does them where the
// whole board is seen.
void TimeStages(const GreyImage& image, const Board& board) {
  const DetectionOptions options;
  const StarTexture texture(board.segments);
  const FeatureRefiner refiner(board, options);
  const std::vector<VisibleTag> tags =
      FindVisibleTags(board, DetectTags(image));
  std::vector<Feature> stars;
  const double growth_ms = MedianMs([&] {
    StarGrowth growth(image, board, texture, refiner.masks(), options, tags);
    growth.Grow();
    stars = growth.lattice().Features();
  });
  const double refinement_ms = MedianMs([&] { refiner.Refine(image, stars); });
  std::printf("DetectTags              %8.2f ms\n",
              MedianMs([&] { DetectTags(image); }));
  std::printf("StarGrowth::Grow        %8.2f ms\n", growth_ms);
  std::printf("FeatureRefiner::Refine  %8.2f ms\n", refinement_ms);
}

void TimeWhole(const GreyImage& image, const StarDetector& detector) {
  const std::vector<Feature> features = detector.Detect(image).features;
  const double all_ms = MedianMs([&] { detector.Detect(image); });
  const double subpix_ms = MedianMs([&] { CornerSubpix(image, features); });
  std::printf("features                %8zu\n", features.size());
  std::printf("StarDetector::Detect    %8.2f ms\n", all_ms);
  std::printf("  per feature           %8.4f ms\n", all_ms / features.size());
  std::printf("cv::cornerSubPix        %8.2f ms\n", subpix_ms);
  std::printf("  per feature           %8.4f ms\n",
              subpix_ms / features.size());
}

void TimeThreads(const GreyImage& image, const StarDetector& detector) {
  constexpr int kNumCopies = 100;
  for (const int num_threads : {1, 2}) {
    const double ms = Milliseconds([&] {
      ParallelFor(kNumCopies, num_threads,
                  [&](int) { detector.Detect(image); });
    });
    std::printf("%d images, %d thread(s)  %8.1f ms\n", kNumCopies, num_threads,
                ms);
  }
}

// Once, for whoever counts instructions, or everything by the clock.
void Run(bool once) {
  const Pattern pattern = LargeBoard();
  const GreyImage image = Photograph(pattern.boards[0]);
  const StarDetector detector(pattern, {});
  if (once) {
    std::printf("features %zu\n", detector.Detect(image).features.size());
    return;
  }
  TimeStages(image, pattern.boards[0]);
  TimeWhole(image, detector);
  TimeThreads(image, detector);
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  raygrid::Run(argc == 2 && std::string(argv[1]) == "--once");
  return 0;
}
