// How many stars are found in rendered images, and how well. Run by hand.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <ctime>
#include <map>
#include <mutex>
#include <opencv2/core.hpp>
#include <set>
#include <tuple>

#include "dataset/files.h"
#include "dataset/parallel_for.h"
#include "features/star_detection.h"
#include "simulation/image_rendering.h"
#include "simulation/random.h"
#include "simulation/simulated_lenses.h"
#include "simulation/simulated_observations.h"
#include "target/star_boards.h"

namespace raygrid {
namespace {

constexpr double kMinStarPx = 12, kMaxErrorPx = 0.5;
// From the image's edge to a star whose window is seen: half of its 21 px, and
// a pixel that refinement leaves out.
constexpr double kWindowPx = 11.5;

struct Arguments {
  int num_images = 1000, only = -1, threads = 2;
  uint64_t seed = 1;
  std::string save;
  bool list = false, plain = false, many_tags = false, large_squares = false;
};

// A lens with its pixels' rays.
struct Camera {
  std::string lens;
  std::unique_ptr<CameraModel> model;
  std::unique_ptr<PixelRays> rays;
};

// What is printed, and how to detect it.
struct Target {
  Pattern pattern;
  std::vector<BoardSurface> surfaces;
  std::vector<Eigen::Vector3d> corners_m;  // where the boards' origins are
  Eigen::Vector3d center_m;
  std::unique_ptr<StarDetector> detector;
};

// Boards side by side, as raygrid simulate puts them.
Target MakeTarget(const StarBoardOptions &options) {
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

// Of many tags, which large boards have room for, one is nearly always seen; of
// large squares the image has room for few, and for small tags only.
std::vector<Target> MakeTargets(bool many_tags, bool large_squares) {
  std::vector<Target> targets;
  const auto add = [&](int columns, int rows, int segments, int num_boards,
                       int few, int many) {
    StarBoardOptions options;
    options.columns = columns;
    options.rows = rows;
    options.square_mm = 12;
    options.segments = segments;
    options.num_boards = num_boards;
    options.num_tags = many_tags ? many : few;
    if (large_squares) options.tag_squares = 2;
    targets.push_back(MakeTarget(options));
  };
  add(16, 15, 16, 1, 1, 4);
  add(24, 16, 16, 1, 1, 6);
  add(12, 10, 16, 2, 1, 1);
  add(16, 15, 12, 1, 1, 4);
  add(24, 16, 8, 1, 2, 6);
  add(12, 12, 20, 2, 1, 1);
  return targets;
}

std::vector<Camera> MakeCameras(int num_threads) {
  std::vector<Camera> cameras;
  for (const char *lens :
       {"pinhole", "example", "wide", "fisheye", "fisheye190"}) {
    for (const ImageSize &size : {ImageSize{640, 480}, ImageSize{1280, 800}}) {
      if (std::string(lens) == "example" && size.width != 640) continue;
      Camera camera;
      camera.lens = lens;
      camera.model = SimulatedLens(lens, size);
      camera.rays = std::make_unique<PixelRays>(*camera.model, num_threads);
      cameras.push_back(std::move(camera));
    }
  }
  return cameras;
}

// Well exposed and sharp, with the noise of a good camera.
ImagingOptions PlainImaging(Random *random) {
  ImagingOptions imaging;
  imaging.blur_px = 0.7;
  imaging.read_noise = 2;
  imaging.samples_per_pixel = 8;
  imaging.seed = static_cast<uint64_t>(random->Uniform(0, 1e15));
  return imaging;
}

// Often blurred, noisy, too dark or too bright.
ImagingOptions RandomImaging(Random *random) {
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

using FeatureKey = std::tuple<int, int, int>;  // board, row, column

// How a star lies in an image.
enum class StarView { kNotToBeFound, kCutByEdge, kWholly };

struct Count {
  int visible = 0, found = 0;

  void Add(const Count &other) {
    visible += other.visible;
    found += other.found;
  }
  double Percent() const {
    return visible == 0 ? 100 : 100.0 * found / visible;
  }
};

// What is to be found in an image, and what was.
struct Outcome {
  TagView tag = TagView::kNone;  // that is seen best
  Count stars;
  std::array<Count, 3> cut_stars_by_tag;  // of their own board
  double largest_of_cut = 0;
  std::array<Count, 3> stars_by_tag;  // of their own board
  int num_features = 0, num_wrong = 0;
  double sum_of_squares = 0, largest = 0, ms = 0;

  Count cut_stars() const {
    Count sum;
    for (const Count &count : cut_stars_by_tag) sum.Add(count);
    return sum;
  }
};

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
  StarView ViewOf(const Feature &star) const;
  TagView ViewOf(size_t board, const BoardTag &tag) const;
};

// Of the square that reaches so far from a star's centre; nothing where one is
// not seen.
std::optional<std::array<Eigen::Vector2d, 4>> Scene::CornersAround(
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

double ShortestSide(const std::array<Eigen::Vector2d, 4> &corners) {
  double shortest = INFINITY;
  for (int k = 0; k < 4; ++k)
    shortest = std::min(shortest, (corners[k] - corners[(k + 1) % 4]).norm());
  return shortest;
}

// Small ones are not to be found.
StarView Scene::ViewOf(const Feature &star) const {
  constexpr double kHalf = 0.5, kNear = 0.05;
  if (const auto corners = CornersAround(star, kHalf))
    return ShortestSide(*corners) < kMinStarPx ? StarView::kNotToBeFound
                                               : StarView::kWholly;
  const auto near = CornersAround(star, kNear);
  const Area pixels = WholeImage(camera->model->image_size());
  return near && ShortestSide(*near) >= 2 * kNear * kMinStarPx &&
                 pixels.Contains(star.pixel, -kWindowPx)
             ? StarView::kCutByEdge
             : StarView::kNotToBeFound;
}

// Of its black square.
TagView Scene::ViewOf(size_t board, const BoardTag &tag) const {
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

Scene MakeScene(const std::vector<Camera> &cameras,
                const std::vector<Target> &targets, const Arguments &arguments,
                int index) {
  Random random(arguments.seed * 1000003 + index);
  Scene scene;
  scene.camera = &cameras[index % cameras.size()];
  scene.target = &targets[random.Index(static_cast<int>(targets.size()))];
  scene.imaging =
      arguments.plain ? PlainImaging(&random) : RandomImaging(&random);
  const double square_m = scene.target->pattern.boards[0].square_m;
  PoseOptions options;
  if (arguments.large_squares) {
    options.min_square_px = 30;
    options.max_square_px = 150;
  }
  scene.pose = RandomPoses(
      *scene.camera->model, scene.target->center_m, square_m, 1, options,
      arguments.seed * 7919 + static_cast<uint64_t>(index))[0];
  return scene;
}

Image Photograph(const Scene &scene) {
  std::vector<PlacedBoard> placed;
  for (size_t b = 0; b < scene.target->surfaces.size(); ++b)
    placed.push_back({&scene.target->surfaces[b], scene.PoseOf(b)});
  return AddNoiseAndQuantize(
      RenderImage(*scene.camera->rays, placed, scene.imaging, 1),
      scene.imaging);
}

void AddError(double error, Outcome *outcome) {
  ++outcome->num_features;
  outcome->num_wrong += error > kMaxErrorPx;
  outcome->largest = std::max(outcome->largest, error);
  outcome->sum_of_squares += error * error;
}

Outcome Compare(const Scene &scene, const std::vector<Feature> &found) {
  Outcome outcome;
  std::map<FeatureKey, Feature> truth;
  const auto &boards = scene.target->pattern.boards;
  std::vector<TagView> views(boards.size(), TagView::kNone);
  for (size_t b = 0; b < boards.size(); ++b) {
    for (const BoardTag &tag : boards[b].tags)
      views[b] = std::max(views[b], scene.ViewOf(b, tag));
    outcome.tag = std::max(outcome.tag, views[b]);
    for (const Feature &f :
         VisibleFeatures(*scene.camera->model, boards[b], scene.PoseOf(b)))
      truth[{f.board, f.row, f.column}] = f;
  }
  std::set<FeatureKey> has;
  for (const Feature &f : found) {
    const FeatureKey key(f.board, f.row, f.column);
    has.insert(key);
    const auto place = truth.find(key);
    constexpr double kNotThere = 1000;
    const bool is_there = place != truth.end();
    const double error =
        is_there ? (f.pixel - place->second.pixel).norm() : kNotThere;
    AddError(error, &outcome);
    if (is_there && scene.ViewOf(place->second) == StarView::kCutByEdge)
      outcome.largest_of_cut = std::max(outcome.largest_of_cut, error);
  }
  for (const auto &[key, feature] : truth) {
    const StarView view = scene.ViewOf(feature);
    const Count star = {1, static_cast<int>(has.count(key))};
    const int tag = static_cast<int>(views[feature.board]);
    if (view == StarView::kWholly) outcome.stars_by_tag[tag].Add(star);
    if (view == StarView::kCutByEdge) outcome.cut_stars_by_tag[tag].Add(star);
  }
  for (const Count &count : outcome.stars_by_tag) outcome.stars.Add(count);
  return outcome;
}

// What this thread has computed, whatever else the machine does.
double ThreadMs() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) +
         1e-6 * static_cast<double>(time.tv_nsec);
}

Outcome Measure(const Scene &scene, const std::string &save) {
  const Image image = Photograph(scene);
  if (!save.empty()) WriteFile(save, EncodePng(image));
  const GreyImage grey = MakeGreyImage(image);
  const double start_ms = ThreadMs();
  const ImageDetection detection = scene.target->detector->Detect(grey);
  const double ms = ThreadMs() - start_ms;
  Outcome outcome = Compare(scene, detection.features);
  outcome.ms = ms;
  return outcome;
}

// Sums over images.
struct Summary {
  int num_images = 0;
  std::array<int, 3> num_by_tag = {0, 0, 0};
  Count stars, stars_in_images_with_tag;
  std::array<Count, 3> stars_by_tag, cut_stars_by_tag;
  int num_features = 0, num_wrong = 0;
  double sum_of_squares = 0, largest = 0, ms = 0, longest_ms = 0;
  double largest_of_cut = 0;

  void Add(const Outcome &o) {
    ++num_images;
    ++num_by_tag[static_cast<int>(o.tag)];
    stars.Add(o.stars);
    if (o.tag == TagView::kWholly) stars_in_images_with_tag.Add(o.stars);
    for (int k = 0; k < 3; ++k) {
      stars_by_tag[k].Add(o.stars_by_tag[k]);
      cut_stars_by_tag[k].Add(o.cut_stars_by_tag[k]);
    }
    largest_of_cut = std::max(largest_of_cut, o.largest_of_cut);
    num_features += o.num_features;
    num_wrong += o.num_wrong;
    sum_of_squares += o.sum_of_squares;
    largest = std::max(largest, o.largest);
    ms += o.ms;
    longest_ms = std::max(longest_ms, o.ms);
  }
  void Print(const std::string &name) const {
    std::printf("%-10s %6d %5d %5d %5d ", name.c_str(), num_images,
                num_by_tag[2], num_by_tag[1], num_by_tag[0]);
    for (const Count &count : {stars, stars_in_images_with_tag, stars_by_tag[2],
                               stars_by_tag[1], stars_by_tag[0]})
      std::printf("%7d %6.2f ", count.visible, count.Percent());
    std::printf("%7.4f %7.3f %5d %5.0f %5.0f\n",
                std::sqrt(sum_of_squares / std::max(1, num_features)), largest,
                num_wrong, ms / std::max(1, num_images), longest_ms);
  }
  void PrintCut(const std::string &name) const {
    std::printf("%-10s ", name.c_str());
    for (const int tag : {2, 1, 0})
      std::printf("%7d %6.2f ", cut_stars_by_tag[tag].visible,
                  cut_stars_by_tag[tag].Percent());
    std::printf("%8.3f %15.3f\n", largest_of_cut,
                ms / std::max(1, num_features));
  }
};

void PrintHead() {
  std::printf(
      "Stars wholly seen, more than %.0f px wide, and %% of them found: in all "
      "images, in those\nwhere a tag is wholly seen, and on boards of which a "
      "tag is seen wholly, partly, not.\n\n"
      "%-10s %6s %17s %14s %14s %14s %14s %14s %15s %5s %11s\n"
      "%-10s %6s %5s %5s %5s %14s %14s %14s %14s %14s %7s %7s %5s %5s %5s\n",
      kMinStarPx, "", "", "images whose tags", "all images", "tag in image",
      "tag wholly", "tag partly", "no tag", "error, px", "", "ms", "lens",
      "images", "whole", "part", "none", "", "", "", "", "", "RMS", "largest",
      "> 0.5", "mean", "most");
}

void PrintHeadOfCut() {
  std::printf(
      "\nStars more than %.1f px from the image's edge that it cuts the "
      "squares "
      "of, and %% of them found.\n\n%-10s %14s %14s %14s %8s %15s\n",
      kWindowPx, "", "tag wholly", "tag partly", "no tag", "largest",
      "ms, any feature");
}

void PrintOne(int index, const Scene &scene, const Outcome &o) {
  std::printf(
      "%4d %-10s %4d px, %d board(s), tag %d: %3d of %3d, cut %3d of %3d, "
      "largest %.3f, %.3f, wrong %d, %.0f ms; exposure %.2f, blur %.1f\n",
      index, scene.camera->lens.c_str(),
      scene.camera->model->image_size().width,
      static_cast<int>(scene.target->surfaces.size()), static_cast<int>(o.tag),
      o.stars.found, o.stars.visible, o.cut_stars().found,
      o.cut_stars().visible, o.largest, o.largest_of_cut, o.num_wrong, o.ms,
      scene.imaging.exposure, scene.imaging.blur_px);
}

void Run(const Arguments &arguments) {
  const std::vector<Camera> cameras = MakeCameras(arguments.threads);
  const std::vector<Target> targets =
      MakeTargets(arguments.many_tags, arguments.large_squares);
  std::vector<Outcome> outcomes(arguments.num_images);
  const auto scene = [&](int i) {
    return MakeScene(cameras, targets, arguments, i);
  };
  if (arguments.only >= 0) {
    const Scene one = scene(arguments.only);
    PrintOne(arguments.only, one, Measure(one, arguments.save));
    return;
  }
  std::atomic<int> num_done{0};
  ParallelFor(arguments.num_images, arguments.threads, [&](int i) {
    outcomes[i] = Measure(scene(i), "");
    std::fprintf(stderr, "\r%d of %d", ++num_done, arguments.num_images);
  });
  std::fprintf(stderr, "\n");
  std::map<std::string, Summary> summaries;
  Summary total;
  for (int i = 0; i < arguments.num_images; ++i) {
    summaries[scene(i).camera->lens].Add(outcomes[i]);
    total.Add(outcomes[i]);
    const Outcome &o = outcomes[i];
    if (arguments.list &&
        (o.stars.found < o.stars.visible ||
         o.cut_stars().found < o.cut_stars().visible || o.num_wrong > 0))
      PrintOne(i, scene(i), o);
  }
  PrintHead();
  for (const auto &[lens, summary] : summaries) summary.Print(lens);
  total.Print("all");
  PrintHeadOfCut();
  for (const auto &[lens, summary] : summaries) summary.PrintCut(lens);
  total.PrintCut("all");
}

}  // namespace
}  // namespace raygrid

int main(int argc, char **argv) {
  raygrid::Arguments arguments;
  CLI::App app("Recall and accuracy of star detection in rendered images.");
  app.add_option("--images", arguments.num_images, "number of images")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  app.add_option("--seed", arguments.seed, "of everything random")
      ->capture_default_str();
  app.add_option("--threads", arguments.threads, "number of threads")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  app.add_flag("--plain", arguments.plain,
               "well exposed and sharp images, noise 2 of 255; by default many "
               "are blurred, noisy, dark or overexposed");
  app.add_flag(
      "--many-tags", arguments.many_tags,
      "four or six tags on large boards; by default one, on one of the "
      "six patterns two");
  app.add_flag("--large-squares", arguments.large_squares,
               "30 to 150 px wide, and tags of two squares; by default 12 to "
               "30 px");
  app.add_flag("--list", arguments.list, "images in which stars are missed");
  app.add_option("--only", arguments.only, "one image, by number");
  app.add_option("--save", arguments.save, "its PNG file");
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(1);
  raygrid::Run(arguments);
  return 0;
}
