#include "capture/frame_quality.h"

#include <cmath>

#include "capture/board_view.h"
#include "capture/keyframe_selector.h"
#include "simulation/board_surface.h"
#include "simulation/image_rendering.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_observations.h"
#include "support.h"
#include "target/board_spec.h"

namespace raygrid {
namespace {

// A board before a camera, and where its features are.
struct BoardImage {
  Board board;
  RenderedImage image;
  std::vector<Feature> features;

  FrameQuality Measured() const {
    return QualityMeter(board).Measure(image.size, image.levels, features);
  }
};

BoardImage RenderBoard(const std::string& spec, const ImagingOptions& options,
                       double turn_rad = 0.3) {
  BoardImage seen;
  seen.board = ReadPatternOrSpec(spec).boards.front();
  const SimulatedCamera camera = ExampleSimulatedCamera();
  const auto pose =
      ComputePose({{320, 240}, 420, 0.4, 1.0, turn_rad}, seen.board, camera);
  const BoardSurface surface(seen.board);
  seen.image =
      RenderImage(PixelRays(camera, 2), {{&surface, *pose}}, options, 2);
  seen.features = VisibleFeatures(camera, seen.board, *pose);
  return seen;
}

// The image moved along its rows while it was exposed.
void Smear(int num_pixels, RenderedImage* image) {
  const RenderedImage sharp = *image;
  for (int row = 0; row < image->size.height; ++row)
    for (int column = 0; column < image->size.width - num_pixels; ++column) {
      double sum = 0;
      for (int k = 0; k < num_pixels; ++k) sum += sharp.at(column + k, row);
      image->levels[static_cast<size_t>(row) * image->size.width + column] =
          static_cast<float>(sum / num_pixels);
    }
}

constexpr const char* kBoards[] = {"chessboard:9x6:25mm",
                                   "charuco:8x6:25mm:marker=18mm",
                                   "aprilgrid:4x4:30mm", "star:9x6:25mm"};

// The pixel itself and the interpolation between pixels spread edges, too.
TEST(FrameQuality, TellsHowFarALensSpreadsEdges) {
  for (const char* spec : kBoards)
    for (const double blur_px : {0.7, 1.2, 2.0}) {
      ImagingOptions options;
      options.blur_px = blur_px;
      const FrameQuality quality = RenderBoard(spec, options).Measured();
      const double expected_px = std::hypot(blur_px, 0.35);
      EXPECT_NEAR(quality.min_spread_px, expected_px, 0.2 * expected_px)
          << spec << " " << blur_px;
      EXPECT_NEAR(quality.max_spread_px, expected_px, 0.2 * expected_px)
          << spec << " " << blur_px;
    }
}

TEST(FrameQuality, TellsMotionFromDefocus) {
  for (const char* spec : kBoards) {
    BoardImage seen = RenderBoard(spec, {});
    const FrameQuality still = seen.Measured();
    Smear(5, &seen.image);
    const FrameQuality moving = seen.Measured();
    EXPECT_NEAR(moving.min_spread_px, still.min_spread_px, 0.25) << spec;
    // Two of five pixels hold 0.4 of a step, as with a Gaussian of 1.9 px.
    EXPECT_NEAR(moving.max_spread_px, 1.9, 0.45) << spec;
  }
}

TEST(FrameQuality, TellsBlackAndWhite) {
  ImagingOptions options;
  options.black_level = 40;
  options.white_level = 190;
  const FrameQuality quality = RenderBoard(kBoards[0], options).Measured();
  EXPECT_NEAR(quality.black, 40, 4);
  EXPECT_NEAR(quality.white, 190, 4);
  EXPECT_EQ(quality.clipped, 0);
  options.exposure = 2;
  BoardImage bright = RenderBoard(kBoards[0], options);
  for (float& level : bright.image.levels) level = std::min(level, 255.0f);
  EXPECT_GT(bright.Measured().clipped, 0.9);
}

TEST(FrameQuality, IsNotKnownWithoutFeatures) {
  BoardImage seen = RenderBoard(kBoards[0], {});
  seen.features.clear();
  EXPECT_EQ(seen.Measured().max_spread_px, 0);
}

}  // namespace
}  // namespace raygrid
