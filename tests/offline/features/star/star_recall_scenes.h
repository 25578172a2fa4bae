// Star boards, lenses and light of star_recall_bench, at random.
#ifndef RAYGRID_TESTS_OFFLINE_FEATURES_STAR_STAR_RECALL_SCENES_H
#define RAYGRID_TESTS_OFFLINE_FEATURES_STAR_STAR_RECALL_SCENES_H

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dataset/kinds/star.h"
#include "features/star/star_detection.h"
#include "simulation/image_rendering.h"
#include "simulation/random.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"

namespace raygrid {

inline constexpr double kMinStarPx = 12, kMaxErrorPx = 0.5;
// From the image's edge to a star whose window is seen: half of its 21 px, and
// a pixel that refinement leaves out.
inline constexpr double kWindowPx = 11.5;

// How large squares are in the image: 12 to 30 px; 30 to 150 px, with tags of
// two squares; 60 to 120 px of 1280, with ordinary tags on one board.
enum class Squares { kOrdinary, kLarge, kClose };

struct SceneOptions {
  Squares squares = Squares::kOrdinary;
  bool is_plain = false, has_many_tags = false;
  uint64_t seed = 1;
};

struct Camera {
  std::string lens;
  std::unique_ptr<CameraModel> model;

  // The rays of the camera's pixels, made when first asked for.
  const PixelRays &Rays() const {
    std::call_once(made_,
                   [this] { rays_ = std::make_unique<PixelRays>(*model, 1); });
    return *rays_;
  }

 private:
  mutable std::once_flag made_;
  mutable std::unique_ptr<PixelRays> rays_;
};

// The printed boards, and their detector.
struct Target {
  Pattern pattern;
  std::vector<BoardSurface> surfaces;
  std::vector<Eigen::Vector3d> corners_m;  // where the boards' origins are
  Eigen::Vector3d center_m;
  std::unique_ptr<StarDetector> detector;
};

// Boards side by side, as raygrid simulate puts them.
inline Target MakeTarget(const StarBoardOptions &options) {
  constexpr double kGapSquares = 4;
  Target target;
  target.pattern.boards = StarBoards(options);
  double x_m = 0;
  for (Board &board : target.pattern.boards) {
    board.points = board.NominalPoints();
    target.surfaces.emplace_back(board);
    target.corners_m.emplace_back(x_m, 0, 0);
    x_m += board.points.back().x() + kGapSquares * board.square_m;
  }
  const Board &last = target.pattern.boards.back();
  target.center_m = {(x_m - kGapSquares * last.square_m) / 2,
                     last.points.back().y() / 2, 0};
  target.detector =
      std::make_unique<StarDetector>(target.pattern, DetectionOptions());
  return target;
}

// Boards to be seen. Large ones have room for many tags, of which one is nearly
// always seen. An image has room for few large squares, and so for small tags
// only.
inline std::vector<Target> MakeTargets(const SceneOptions &scenes) {
  std::vector<Target> targets;
  const auto add = [&](int columns, int rows, int segments, int num_boards,
                       int few_tags, int many_tags, int tag_squares) {
    StarBoardOptions options;
    options.columns = columns;
    options.rows = rows;
    options.square_mm = 12;
    options.segments = segments;
    options.num_boards = num_boards;
    options.num_tags = scenes.has_many_tags ? many_tags : few_tags;
    options.tag_squares = tag_squares;
    targets.push_back(MakeTarget(options));
  };
  if (scenes.squares == Squares::kClose) {
    add(16, 23, 16, 1, 1, 4, 4);
    add(16, 23, 12, 1, 2, 4, 4);
    add(23, 16, 16, 1, 1, 4, 5);
    return targets;
  }
  constexpr int kChosen = 0;
  const int tag_squares = scenes.squares == Squares::kLarge ? 2 : kChosen;
  add(16, 15, 16, 1, 1, 4, tag_squares);
  add(24, 16, 16, 1, 1, 6, tag_squares);
  add(12, 10, 16, 2, 1, 1, tag_squares);
  add(16, 15, 12, 1, 1, 4, tag_squares);
  add(24, 16, 8, 1, 2, 6, tag_squares);
  add(12, 12, 20, 2, 1, 1, tag_squares);
  return targets;
}

inline std::deque<Camera> MakeCameras(Squares squares) {
  constexpr ImageSize kVga = {640, 480}, kWide = {1280, 800},
                      kHigh = {1280, 1024};
  const auto sizes_of = [&](const std::string &lens) {
    if (lens == "example") return std::vector<ImageSize>{kVga};
    return std::vector<ImageSize>{squares == Squares::kClose ? kHigh : kVga,
                                  kWide};
  };
  std::deque<Camera> cameras;
  for (const char *lens :
       {"pinhole", "example", "wide", "fisheye", "fisheye190"}) {
    for (const ImageSize &size : sizes_of(lens)) {
      Camera &camera = cameras.emplace_back();
      camera.lens = lens;
      camera.model = MakeSimulatedCamera(lens, size);
    }
  }
  return cameras;
}

// Well exposed and sharp, with the noise of a good camera.
inline ImagingOptions PlainImaging(Random *random) {
  ImagingOptions imaging;
  imaging.blur_px = 0.7;
  imaging.read_noise = 2;
  imaging.samples_per_pixel = 8;
  imaging.seed = static_cast<uint64_t>(random->Uniform(0, 1e15));
  return imaging;
}

// Often blurred, noisy, too dark or too bright.
inline ImagingOptions RandomImaging(Random *random) {
  ImagingOptions imaging;
  imaging.blur_px = random->Uniform(0.5, 1.5);
  imaging.read_noise = random->Uniform(1, 4);
  imaging.shot_noise = random->Uniform(0, 0.05);
  imaging.vignetting = random->Uniform(0, 0.5);
  imaging.samples_per_pixel = 4;
  const double light = random->Uniform(0, 1);
  if (light < 0.15) imaging.exposure = random->Uniform(0.2, 0.5);
  if (light > 0.85) imaging.exposure = random->Uniform(1.2, 1.8);
  imaging.seed = static_cast<uint64_t>(random->Uniform(0, 1e15));
  return imaging;
}

enum class TagView { kNone, kPartly, kWholly };

// How a star lies in an image.
enum class StarView { kNotToBeFound, kCutByEdge, kWholly };

struct Scene {
  const Camera *camera;
  const Target *target;
  Pose pose;
  ImagingOptions imaging;

  Pose PoseOf(size_t board) const {
    return {pose.rotation, pose * target->corners_m[board]};
  }
  std::optional<Eigen::Vector2d> Project(size_t board, double column,
                                         double row) const {
    const double s = target->pattern.boards[board].square_m;
    const auto pixel = camera->model->Project(
        PoseOf(board) * Eigen::Vector3d(column * s, row * s, 0));
    if (!pixel || !WholeImage(camera->model->image_size()).Contains(*pixel))
      return std::nullopt;
    return pixel;
  }
  std::optional<std::array<Eigen::Vector2d, 4>> CornersAround(
      const Feature &star, double reach_squares) const;
  double SizePx(const Feature &star) const;
  bool SeesWindowOf(const Feature &star) const;
  StarView ViewOf(const Feature &star) const;
  TagView ViewOf(size_t board, const BoardTag &tag) const;
};

// The corners of the square that reaches so far from a star's centre; nothing
// where one is not seen.
inline std::optional<std::array<Eigen::Vector2d, 4>> Scene::CornersAround(
    const Feature &star, double reach_squares) const {
  constexpr double kSigns[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  std::array<Eigen::Vector2d, 4> corners;
  for (int k = 0; k < 4; ++k) {
    const auto corner =
        Project(star.board, star.column + reach_squares * kSigns[k][0],
                star.row + reach_squares * kSigns[k][1]);
    if (!corner) return std::nullopt;
    corners[k] = *corner;
  }
  return corners;
}

inline double ShortestSide(const std::array<Eigen::Vector2d, 4> &corners) {
  double shortest = INFINITY;
  for (int k = 0; k < 4; ++k)
    shortest = std::min(shortest, (corners[k] - corners[(k + 1) % 4]).norm());
  return shortest;
}

// How wide its square is, as the middle of it tells; 0 where that is not seen.
inline double Scene::SizePx(const Feature &star) const {
  constexpr double kNear = 0.05;
  const auto near = CornersAround(star, kNear);
  return near ? ShortestSide(*near) / (2 * kNear) : 0;
}

// Whether a star's window lies in the image, and in the image circle.
inline bool Scene::SeesWindowOf(const Feature &star) const {
  if (!WholeImage(camera->model->image_size()).Contains(star.pixel, -kWindowPx))
    return false;
  constexpr int kDirections = 16;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * M_PI * k / kDirections;
    const Eigen::Vector2d rim =
        star.pixel +
        kWindowPx * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    if (!camera->model->Unproject(rim)) return false;
  }
  return true;
}

// Small ones are not to be found.
inline StarView Scene::ViewOf(const Feature &star) const {
  constexpr double kHalf = 0.5;
  if (const auto corners = CornersAround(star, kHalf))
    return ShortestSide(*corners) < kMinStarPx ? StarView::kNotToBeFound
                                               : StarView::kWholly;
  return SizePx(star) >= kMinStarPx && SeesWindowOf(star)
             ? StarView::kCutByEdge
             : StarView::kNotToBeFound;
}

// The view of a tag's black square.
inline TagView Scene::ViewOf(size_t board, const BoardTag &tag) const {
  const double cell = tag.squares / 10.0;
  constexpr int kNumSteps = 8;
  int num_seen = 0;
  for (int j = 0; j <= kNumSteps; ++j)
    for (int i = 0; i <= kNumSteps; ++i)
      num_seen += Project(board, tag.column + cell * (1 + 8.0 * i / kNumSteps),
                          tag.row + cell * (1 + 8.0 * j / kNumSteps))
                      .has_value();
  if (num_seen == 0) return TagView::kNone;
  return num_seen == (kNumSteps + 1) * (kNumSteps + 1) ? TagView::kWholly
                                                       : TagView::kPartly;
}

inline PoseOptions PosesOf(Squares squares, const ImageSize &size) {
  PoseOptions options;
  if (squares == Squares::kLarge) {
    options.min_square_px = 30;
    options.max_square_px = 150;
  }
  if (squares == Squares::kClose) {
    options.min_square_px = 60 * size.width / 1280.0;
    options.max_square_px = 120 * size.width / 1280.0;
  }
  return options;
}

inline Scene MakeScene(const std::deque<Camera> &cameras,
                       const std::vector<Target> &targets,
                       const SceneOptions &scenes, int index) {
  Random random(scenes.seed * 1000003 + index);
  Scene scene;
  scene.camera = &cameras[index % cameras.size()];
  scene.target = &targets[random.Index(static_cast<int>(targets.size()))];
  scene.imaging =
      scenes.is_plain ? PlainImaging(&random) : RandomImaging(&random);
  const double square_m = scene.target->pattern.boards[0].square_m;
  const CameraModel &lens = *scene.camera->model;
  scene.pose =
      RandomPoses(lens, scene.target->center_m, square_m, 1,
                  PosesOf(scenes.squares, lens.image_size()),
                  scenes.seed * 7919 + static_cast<uint64_t>(index))[0];
  return scene;
}

inline Image Photograph(const Scene &scene) {
  std::vector<PlacedBoard> placed;
  for (size_t b = 0; b < scene.target->surfaces.size(); ++b)
    placed.push_back({&scene.target->surfaces[b], scene.PoseOf(b)});
  return AddNoiseAndQuantize(
      RenderImage(scene.camera->Rays(), placed, scene.imaging, 1),
      scene.imaging);
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_FEATURES_STAR_STAR_RECALL_SCENES_H
