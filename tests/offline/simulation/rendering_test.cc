#include <Eigen/LU>

#include "simulation/image_rendering.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr ImageSize kSize = {320, 240};

Board StarBoard() {
  return ParsePattern(
             "pattern",
             "raygrid_pattern: 1\n"
             "boards:\n"
             "  - {id: 0, kind: star, columns: 16, rows: 23, square_m: "
             "0.012, segments: 16, tags: [{family: tag36h11, id: 0, "
             "column: 5, row: 9, squares: 4}]}\n")
      .boards[0];
}

Board TwoByTwo(double square_m) {
  return ChessboardPattern(2, 2, square_m).boards[0];
}

// Ink is 0, everything else 200.
ImagingOptions PlainOptions() {
  ImagingOptions options;
  options.black_level = 0;
  options.white_level = 200;
  options.background_level = 200;
  return options;
}

Pose Facing(const Board& board, double z_m, double tilt_rad) {
  const Eigen::Quaterniond rotation(
      Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d(0.3, 1, 0).normalized()) *
      Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d center = board.points.back() / 2;
  return {rotation, Eigen::Vector3d(0.0012, -0.0007, z_m) - rotation * center};
}

// How much ink there is in a row, in pixels.
double InkInRow(const RenderedImage& image, int row, int first, int last) {
  double ink = 0;
  for (int x = first; x <= last; ++x) ink += 1 - image.at(x, row) / 200;
  return ink;
}

// The column where the board's edge x = x_m crosses a row of the image.
double EdgeInRow(const CameraModel& camera, const Pose& pose,
                 const BoardCurvature& bend, double x_m, double row,
                 double y_m) {
  Eigen::Vector2d pixel;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const auto project = [&](double y) {
      return camera.Project(pose * Eigen::Vector3d(x_m, y, bend.Height(x_m, y)))
          .value();
    };
    pixel = project(y_m);
    const double slope = (project(y_m + 1e-7) - pixel).y() / 1e-7;
    y_m += (row - pixel.y()) / slope;
  }
  return pixel.x();
}

// The left edge of the black square between the features, by how much ink there
// is from before it to the square's middle, and by projection.
void ExpectExactEdges(const CameraModel& camera, double bend_m,
                      double tolerance_px) {
  Board board = TwoByTwo(0.04);
  const BoardSurface surface(board, bend_m);
  const BoardCurvature bend(board, bend_m);
  const PixelRays rays(camera, 2);
  double largest = 0;
  for (const double tilt : {0.0, 0.1, 0.5, -0.7}) {
    const Pose pose = Facing(board, 0.13, tilt);
    const RenderedImage image =
        RenderImage(rays, {{&surface, pose}}, PlainOptions(), 2);
    const Eigen::Vector2d middle =
        camera.Project(pose * Eigen::Vector3d(0.02, 0.02, 0)).value();
    for (int row = static_cast<int>(middle.y()) - 5; row < middle.y() + 5;
         ++row) {
      // The pixel's rows are averaged over the box and the blur: the edge is
      // nearly straight.
      const double left = EdgeInRow(camera, pose, bend, 0, row, 0.02);
      const int center = static_cast<int>(middle.x());
      const int first = static_cast<int>(left) - 6;
      const double ink = InkInRow(image, row, first, center);
      largest = std::max(largest, std::abs(center + 0.5 - ink - left));
    }
  }
  EXPECT_LT(largest, tolerance_px);
}

TEST(RenderImage, EdgesLieWhereTheProjectionSays) {
  for (const char* lens : {"pinhole", "wide", "fisheye", "fisheye190"})
    ExpectExactEdges(*MakeSimulatedCamera(lens, kSize), 0, 0.0005);
}

TEST(RenderImage, EdgesOfBentBoardsLieWhereTheProjectionSays) {
  ExpectExactEdges(*MakeSimulatedCamera("pinhole", kSize), 0.002, 0.001);
}

// The second moment of an edge's derivative, about its place, in a row.
double EdgeVariance(const RenderedImage& image, int row, double edge) {
  double variance = 0;
  for (int x = static_cast<int>(edge) - 9; x < edge + 9; ++x) {
    const double weight = (image.at(x, row) - image.at(x + 1, row)) / 200;
    variance += weight * (x + 0.5 - edge) * (x + 0.5 - edge);
  }
  return variance;
}

TEST(RenderImage, BlurHasTheWidthAskedFor) {
  const Board board = TwoByTwo(0.04);
  const BoardSurface surface(board);
  const auto camera = MakeSimulatedCamera("pinhole", kSize);
  const Pose pose = {Eigen::Quaterniond::Identity(), {-0.02, -0.02, 0.13}};
  const double edge = camera->Project(pose * Eigen::Vector3d(0, 0.02, 0))->x();
  for (const double blur : {0.5, 0.7, 1.5}) {
    ImagingOptions options = PlainOptions();
    options.blur_px = blur;
    const RenderedImage image =
        RenderImage(PixelRays(*camera, 2), {{&surface, pose}}, options, 2);
    // The pixel's box adds 1/12, the difference of neighbours as much again.
    const double variance = EdgeVariance(image, 120, edge) - 2.0 / 12;
    EXPECT_NEAR(std::sqrt(variance), blur, 0.02) << blur;
  }
}

// Patches that tile the board hold all its ink, whatever their size.
TEST(InkMap, AreaOfTheInkIsExact) {
  const InkMap ink{BoardAppearance(TwoByTwo(0.004))};
  for (const int steps : {37, 300, 1000}) {
    const double step_m = 0.014 / steps;
    const Footprint patch(Eigen::Matrix2d::Identity() * step_m);
    double area = 0;
    for (int j = 0; j < steps; ++j)
      for (int i = 0; i < steps; ++i)
        area += ink.InkFraction(
                    {-0.005 + (i + 0.5) * step_m, -0.005 + (j + 0.5) * step_m},
                    patch) *
                step_m * step_m;
    EXPECT_NEAR(area / (5 * 0.004 * 0.004), 1, steps < 100 ? 1e-3 : 1e-4);
  }
}

// The centroid of a board's ink in the image, integrated over the board.
Eigen::Vector2d CentroidOfInk(const CameraModel& camera,
                              const BoardAppearance& appearance,
                              const Pose& pose) {
  constexpr int kSteps = 300;
  const Area& area = appearance.extent_m();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int j = 0; j < kSteps; ++j) {
    for (int i = 0; i < kSteps; ++i) {
      const Eigen::Vector2d at(area.x0 + area.width() * (i + 0.5) / kSteps,
                               area.y0 + area.height() * (j + 0.5) / kSteps);
      if (!appearance.IsBlack(at)) continue;
      LinearizedProjection seen;
      camera.Linearize(pose * Eigen::Vector3d(at.x(), at.y(), 0), nullptr, 0,
                       &seen);
      const double density =
          (seen.J_point * pose.rotation.toRotationMatrix().leftCols<2>())
              .determinant();
      sum += density * seen.pixel.homogeneous();
    }
  }
  return sum.hnormalized();
}

TEST(RenderImage, CentroidOfTheInkIsExact) {
  const Board board = TwoByTwo(0.004);
  const BoardSurface surface(board);
  const auto camera = MakeSimulatedCamera("pinhole", kSize);
  const PixelRays rays(*camera, 1);
  for (int i = 0; i < 5; ++i) {
    const Pose pose = {Eigen::Quaterniond::Identity(),
                       {0.001 + 0.00037 * i, 0.002 - 0.00011 * i, 0.1}};
    const RenderedImage image =
        RenderImage(rays, {{&surface, pose}}, PlainOptions(), 1);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int y = 0; y < kSize.height; ++y)
      for (int x = 0; x < kSize.width; ++x)
        sum += (200 - image.at(x, y)) * Eigen::Vector3d(x, y, 1);
    const Eigen::Vector2d exact =
        CentroidOfInk(*camera, BoardAppearance(board), pose);
    EXPECT_LT((sum.hnormalized() - exact).norm(), 0.0005);
  }
}

TEST(RenderImage, AnyNumberOfThreadsGivesTheSameBytes) {
  const Board board = StarBoard();
  const BoardSurface surface(board);
  const auto camera = MakeSimulatedCamera("wide", {321, 241});
  const Pose pose = Facing(board, 0.2, 0.4);
  const RenderedImage one = RenderImage(
      PixelRays(*camera, 1), {{&surface, pose}}, ImagingOptions(), 1);
  const RenderedImage three = RenderImage(
      PixelRays(*camera, 3), {{&surface, pose}}, ImagingOptions(), 3);
  EXPECT_EQ(one.levels, three.levels);
}

TEST(RenderImage, VignettingTakesItsPartInTheCorners) {
  ImagingOptions options = PlainOptions();
  options.vignetting = 0.4;
  const RenderedImage image = RenderImage(
      PixelRays(*MakeSimulatedCamera("pinhole", kSize), 1), {}, options, 1);
  EXPECT_NEAR(image.at(0, 0), 0.6 * 200, 1e-3);
  EXPECT_NEAR(image.at(319, 239), 0.6 * 200, 1e-3);
  EXPECT_NEAR(image.at(160, 120), 200, 0.1);
}

TEST(RenderImage, NearerBoardsHideFartherOnes) {
  const Board board = TwoByTwo(0.04);
  const BoardSurface surface(board), small(TwoByTwo(0.01));
  const auto camera = MakeSimulatedCamera("pinhole", kSize);
  const Pose far = {Eigen::Quaterniond::Identity(), {-0.02, -0.02, 0.2}};
  const Pose near = {Eigen::Quaterniond::Identity(), {-0.005, -0.005, 0.1}};
  const PixelRays rays(*camera, 1);
  const auto render = [&](const std::vector<PlacedBoard>& boards) {
    return RenderImage(rays, boards, PlainOptions(), 1).levels;
  };
  EXPECT_EQ(render({{&surface, far}, {&small, near}}),
            render({{&small, near}, {&surface, far}}));
}

TEST(AddNoiseAndQuantize, NoiseHasTheVarianceAskedFor) {
  RenderedImage grey = {kSize, std::vector<float>(320 * 240, 100.0f)};
  ImagingOptions options;
  options.read_noise = 3;
  options.shot_noise = 0.2;
  const Image16 image = AddNoiseAndQuantize16(grey, options);
  double sum = 0, squares = 0;
  for (const uint16_t pixel : image.pixels) {
    sum += pixel / 257.0 - 100;
    squares += std::pow(pixel / 257.0 - 100, 2);
  }
  EXPECT_NEAR(sum / image.pixels.size(), 0, 0.1);
  EXPECT_NEAR(squares / image.pixels.size(), 9 + 20, 0.5);
}

TEST(AddNoiseAndQuantize, GammaAndSaturation) {
  const RenderedImage grey = {{3, 1}, {-5, 63.75f, 300}};
  ImagingOptions options;
  options.gamma = 2;
  EXPECT_EQ(AddNoiseAndQuantize(grey, options).pixels,
            (std::vector<uint8_t>{0, 128, 255}));
}

TEST(MakeSimulatedCamera, ProjectionInvertsUnprojection) {
  for (const char* name : {"pinhole", "wide", "fisheye"})
    ExpectRoundTrip(*MakeSimulatedCamera(name, kSize), 1e-6);
}

TEST(MakeSimulatedCamera, DerivativeByPointIsThatOfProjection) {
  for (const char* name : {"pinhole", "wide", "fisheye"})
    ExpectDerivativeByPoint(*MakeSimulatedCamera(name, kSize), 1e-5);
}

TEST(MakeSimulatedCamera, FisheyeSeesBehindTheImagePlane) {
  const auto camera = MakeSimulatedCamera("fisheye190", kSize);
  const auto left = camera->Unproject({0, 120});
  ASSERT_TRUE(left);
  EXPECT_LT(left->z(), 0);
  EXPECT_LT(
      (camera->Project(*left * 2).value() - Eigen::Vector2d(0, 120)).norm(),
      1e-9);
}

TEST(MakeSimulatedCamera, UnknownNamesAreRefused) {
  ExpectError(ExitCode::kInvalidInput, {"fisheye190"},
              [] { MakeSimulatedCamera("zoom", kSize); });
  ExpectError(ExitCode::kInvalidInput, {"640x480"},
              [] { MakeSimulatedCamera("example", kSize); });
}

TEST(RenderObservations, OfANonCentralLensLieOnItsLines) {
  const auto lens = MakeSimulatedCamera("noncentral", kSize);
  SimulationOptions options;
  options.num_images = 3;
  options.features_per_image = 40;
  options.noise_px = 0;
  const SimulatedObservations seen =
      SimulateObservations(*lens, ChessboardPattern(10, 8, 0.02), options);
  const Board& board = seen.true_pattern.boards[0];
  ASSERT_EQ(seen.dataset.num_features(), 120u);
  double largest_m = 0, farthest_from_center_m = 0;
  for (size_t i = 0; i < seen.poses.size(); ++i) {
    for (const Feature& f : seen.dataset.images[i].features) {
      const ObservationLine line = lens->Line(f.pixel).value();
      const Eigen::Vector3d point =
          seen.poses[i].camera_from_board *
          board.points[board.PointIndex(f.column, f.row)];
      largest_m = std::max(largest_m,
                           (point - line.origin).cross(line.direction).norm());
      farthest_from_center_m =
          std::max(farthest_from_center_m, point.cross(line.direction).norm());
    }
  }
  EXPECT_LT(largest_m, 1e-9);
  EXPECT_GT(farthest_from_center_m, 1e-4);  // the lens is not central
}

TEST(RenderObservations, ImagesThatHardlyOccurAreRefused) {
  const Pattern pattern = ChessboardPattern(10, 8, 0.02);
  SimulationOptions options;
  options.features_per_image = 81;  // one more than there are
  ExpectError(ExitCode::kInsufficientData, {"81 features"}, [&] {
    SimulateObservations(*MakeSimulatedCamera("pinhole", kSize), pattern,
                         options);
  });
}

TEST(RandomPoses, BoardsLookOutOfAllTheImageAtTheSizesAskedFor) {
  const auto camera = MakeSimulatedCamera("fisheye190", kSize);
  const Board board = StarBoard();
  const Eigen::Vector3d center = board.points.back() / 2;
  PoseOptions options;
  int near_the_edge = 0;
  for (const Pose& pose :
       RandomPoses(*camera, center, board.square_m, 200, options, 5)) {
    const Eigen::Vector3d point = pose * center;
    ASSERT_TRUE(camera->Project(point));
    near_the_edge += std::acos(point.normalized().z()) > 1.3;
    // The board's front looks to the camera.
    EXPECT_GT((pose.rotation * Eigen::Vector3d::UnitZ()).dot(point), 0);
  }
  EXPECT_GT(near_the_edge, 10);
}

}  // namespace
}  // namespace raygrid
