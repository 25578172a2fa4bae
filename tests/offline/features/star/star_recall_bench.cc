// How many stars are found in rendered images, and how well. Run by hand.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <set>
#include <tuple>

#include "dataset/files.h"
#include "dataset/parallel_for.h"
#include "star_recall_scenes.h"

namespace raygrid {
namespace {

struct Arguments {
  int num_images = 1000, only = -1, threads = 2;
  SceneOptions scenes;
  std::string keep;  // a folder; or empty
  bool list = false;

  // The file that an image is kept in; empty if it is not kept.
  std::string FileOf(int index) const {
    return keep.empty() ? "" : fmt::format("{}/{:04d}.png", keep, index);
  }
};

using FeatureKey = std::tuple<int, int, int>;  // board, row, column

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

// By how wide stars' squares are.
constexpr std::array<double, 4> kSizesPx = {15, 30, 60, 120};
constexpr size_t kNumSizes = kSizesPx.size() + 1;

size_t SizeIndex(double size_px) {
  return std::upper_bound(kSizesPx.begin(), kSizesPx.end(), size_px) -
         kSizesPx.begin();
}

// Stars of one view, by size, on boards of which a tag is wholly seen.
struct BySize {
  std::array<Count, kNumSizes> counts;
  std::array<double, kNumSizes> largest = {};
  std::map<std::string, int> missed;  // by reason

  void Add(const BySize &other) {
    for (size_t k = 0; k < kNumSizes; ++k) {
      counts[k].Add(other.counts[k]);
      largest[k] = std::max(largest[k], other.largest[k]);
    }
    for (const auto &[reason, count] : other.missed) missed[reason] += count;
  }
};

// A star that was not found.
struct Missed {
  Feature star;
  bool is_cut;
  std::string reason;
};

// The stars and tags to be found in an image, and what was found.
struct Outcome {
  TagView tag = TagView::kNone;  // that is seen best
  Count stars;
  std::array<Count, 3> cut_stars_by_tag;  // of their own board
  double largest_of_cut = 0;
  std::array<Count, 3> stars_by_tag;  // of their own board
  int num_features = 0, num_wrong = 0;
  double sum_of_squares = 0, largest = 0, ms = 0;
  std::array<BySize, 2> by_size;  // wholly seen, cut
  std::vector<Missed> missed;     // where a tag of the board is wholly seen

  Count cut_stars() const {
    Count sum;
    for (const Count &count : cut_stars_by_tag) sum.Add(count);
    return sum;
  }
};

void AddError(double error, Outcome *outcome) {
  ++outcome->num_features;
  outcome->num_wrong += error > kMaxErrorPx;
  outcome->largest = std::max(outcome->largest, error);
  outcome->sum_of_squares += error * error;
}

FeatureKey KeyOf(const Feature &f) { return {f.board, f.row, f.column}; }

// By board, row, column.
std::map<FeatureKey, Feature> TruthOf(const Scene &scene) {
  std::map<FeatureKey, Feature> truth;
  const auto &boards = scene.target->pattern.boards;
  for (size_t b = 0; b < boards.size(); ++b)
    for (const Feature &f :
         VisibleFeatures(*scene.camera->model, boards[b], scene.PoseOf(b)))
      truth[KeyOf(f)] = f;
  return truth;
}

// Why stars were not found, and what to say of those that were not sought.
class Reasons {
 public:
  explicit Reasons(const ImageDetection &detection) {
    for (const Feature &f : detection.features) boards_.insert(f.board);
    for (const RejectedFeature &r : detection.rejected)
      reasons_.emplace(KeyOf(r.feature), r.reason);
  }

  std::string Of(const Feature &star) const {
    const auto known = reasons_.find(KeyOf(star));
    if (boards_.count(star.board) == 0) return "board not found";
    return known != reasons_.end() ? known->second : "not sought";
  }

 private:
  std::set<int> boards_;
  std::map<FeatureKey, std::string> reasons_;
};

// How well each board's tag is seen that is seen best.
std::vector<TagView> TagViews(const Scene &scene) {
  const auto &boards = scene.target->pattern.boards;
  std::vector<TagView> views(boards.size(), TagView::kNone);
  for (size_t b = 0; b < boards.size(); ++b)
    for (const BoardTag &tag : boards[b].tags)
      views[b] = std::max(views[b], scene.ViewOf(b, tag));
  return views;
}

void AddStar(const Scene &scene, const Feature &star, TagView tag,
             const Feature *found, const Reasons &reasons, Outcome *outcome) {
  const StarView view = scene.ViewOf(star);
  if (view == StarView::kNotToBeFound) return;
  const bool is_cut = view == StarView::kCutByEdge;
  const Count count = {1, found != nullptr};
  const double error = found ? (found->pixel - star.pixel).norm() : 0;
  auto &by_tag = is_cut ? outcome->cut_stars_by_tag : outcome->stars_by_tag;
  by_tag[static_cast<int>(tag)].Add(count);
  if (!is_cut) outcome->stars.Add(count);
  if (is_cut)
    outcome->largest_of_cut = std::max(outcome->largest_of_cut, error);
  if (tag != TagView::kWholly) return;
  BySize &by_size = outcome->by_size[is_cut];
  const size_t size = SizeIndex(scene.SizePx(star));
  by_size.counts[size].Add(count);
  by_size.largest[size] = std::max(by_size.largest[size], error);
  if (found) return;
  outcome->missed.push_back({star, is_cut, reasons.Of(star)});
  ++by_size.missed[reasons.Of(star)];
}

Outcome Compare(const Scene &scene, const ImageDetection &detection) {
  Outcome outcome;
  const std::vector<TagView> views = TagViews(scene);
  outcome.tag = *std::max_element(views.begin(), views.end());
  const std::map<FeatureKey, Feature> truth = TruthOf(scene);
  std::map<FeatureKey, Feature> found;
  for (const Feature &f : detection.features) {
    constexpr double kNotThere = 1000;
    found[KeyOf(f)] = f;
    const auto place = truth.find(KeyOf(f));
    AddError(place == truth.end() ? kNotThere
                                  : (f.pixel - place->second.pixel).norm(),
             &outcome);
  }
  const Reasons reasons(detection);
  for (const auto &[key, star] : truth) {
    const auto place = found.find(key);
    AddStar(scene, star, views[star.board],
            place == found.end() ? nullptr : &place->second, reasons, &outcome);
  }
  return outcome;
}

// CPU time of this thread, whatever else the machine does.
double ThreadMs() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) +
         1e-6 * static_cast<double>(time.tv_nsec);
}

// Rendered, or as it was kept.
GreyImage SimulateImageFeatures(const Scene &scene, const std::string &file) {
  if (!file.empty() && std::filesystem::exists(file))
    return MakeGreyImage(ReadImage(file, true));
  const Image image = Photograph(scene);
  if (!file.empty()) WriteFile(file, EncodePng(image));
  return MakeGreyImage(image);
}

Outcome Measure(const Scene &scene, const std::string &file) {
  const GreyImage grey = SimulateImageFeatures(scene, file);
  const double start_ms = ThreadMs();
  const ImageDetection detection = scene.target->detector->Detect(grey);
  const double ms = ThreadMs() - start_ms;
  Outcome outcome = Compare(scene, detection);
  outcome.ms = ms;
  return outcome;
}

// Sums over images.
struct Summary {
  int num_images = 0;
  std::array<int, 3> num_by_tag = {0, 0, 0};
  Count stars, stars_in_images_with_tag;
  std::array<Count, 3> stars_by_tag, cut_stars_by_tag;
  std::array<BySize, 2> by_size;
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
    for (int k = 0; k < 2; ++k) by_size[k].Add(o.by_size[k]);
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
  void PrintBySize(const std::string &name, bool is_cut) const {
    std::printf("%-10s ", name.c_str());
    for (size_t k = 0; k < kNumSizes; ++k)
      std::printf("%7d %6.2f %6.3f ", by_size[is_cut].counts[k].visible,
                  by_size[is_cut].counts[k].Percent(),
                  by_size[is_cut].largest[k]);
    std::printf("\n");
  }
  void PrintMissed(const std::string &name) const {
    for (const bool is_cut : {false, true})
      for (const auto &[reason, count] : by_size[is_cut].missed)
        std::printf("%-10s %-6s %7d %s\n", name.c_str(),
                    is_cut ? "cut" : "wholly", count, reason.c_str());
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

void PrintHeadBySize(bool is_cut) {
  std::printf(
      "\nStars %s, on boards of which a tag is wholly seen, by the width of "
      "their squares:\nhow many, %% found, largest error in px.\n\n%-10s ",
      is_cut ? "cut by the edge" : "wholly seen", "");
  for (size_t k = 0; k < kNumSizes; ++k)
    std::printf(k < kSizesPx.size() ? "%13s< %3.0f px " : "%14s%3.0f px ",
                k < kSizesPx.size() ? "" : "from ",
                kSizesPx[std::min(k, kSizesPx.size() - 1)]);
  std::printf("\n");
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

void PrintTables(const std::map<std::string, Summary> &summaries,
                 const Summary &total) {
  PrintHead();
  for (const auto &[lens, summary] : summaries) summary.Print(lens);
  total.Print("all");
  PrintHeadOfCut();
  for (const auto &[lens, summary] : summaries) summary.PrintCut(lens);
  total.PrintCut("all");
  for (const bool is_cut : {false, true}) {
    PrintHeadBySize(is_cut);
    for (const auto &[lens, summary] : summaries)
      summary.PrintBySize(lens, is_cut);
    total.PrintBySize("all", is_cut);
  }
  std::printf("\nThose that were not found.\n\n");
  for (const auto &[lens, summary] : summaries) summary.PrintMissed(lens);
}

void Run(const Arguments &arguments) {
  const std::deque<Camera> cameras = MakeCameras(arguments.scenes.squares);
  const std::vector<Target> targets = MakeTargets(arguments.scenes);
  std::vector<Outcome> outcomes(arguments.num_images);
  const auto scene = [&](int i) {
    return MakeScene(cameras, targets, arguments.scenes, i);
  };
  if (arguments.only >= 0) {
    const Scene one = scene(arguments.only);
    const Outcome outcome = Measure(one, arguments.FileOf(arguments.only));
    PrintOne(arguments.only, one, outcome);
    for (const Missed &missed : outcome.missed)
      std::printf("board %d, column %d, row %d at %.1f, %.1f%s: %s\n",
                  missed.star.board, missed.star.column, missed.star.row,
                  missed.star.pixel.x(), missed.star.pixel.y(),
                  missed.is_cut ? ", cut" : "", missed.reason.c_str());
    return;
  }
  std::atomic<int> num_done{0};
  ParallelFor(arguments.num_images, arguments.threads, [&](int i) {
    outcomes[i] = Measure(scene(i), arguments.FileOf(i));
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
  PrintTables(summaries, total);
}

}  // namespace
}  // namespace raygrid

int main(int argc, char **argv) {
  raygrid::Arguments arguments;
  using raygrid::Squares;
  CLI::App app("Recall and accuracy of star detection in rendered images.");
  app.add_option("--images", arguments.num_images, "number of images")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  app.add_option("--seed", arguments.scenes.seed, "of everything random")
      ->capture_default_str();
  app.add_option("--threads", arguments.threads, "number of threads")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  app.add_flag("--plain", arguments.scenes.is_plain,
               "well exposed and sharp images, noise 2 of 255; by default many "
               "are blurred, noisy, dark or overexposed");
  app.add_flag(
      "--many-tags", arguments.scenes.has_many_tags,
      "four or six tags on large boards; by default one, on one of the "
      "six patterns two");
  const std::map<std::string, Squares> squares = {
      {"ordinary", Squares::kOrdinary},
      {"large", Squares::kLarge},
      {"close", Squares::kClose}};
  app.add_option("--squares", arguments.scenes.squares,
                 "ordinary: 12 to 30 px wide; large: 30 to 150 px, and tags of "
                 "two squares; close: 60 to 120 px in images 1280 px wide, one "
                 "board of 16 x 23 stars, and tags of four or five squares")
      ->transform(CLI::CheckedTransformer(squares));
  app.add_flag("--list", arguments.list, "images in which stars are missed");
  app.add_option("--only", arguments.only, "one image, by number");
  app.add_option("--keep", arguments.keep,
                 "a folder of images (0000.png ...) of the same options: those "
                 "that are there are not rendered again");
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(1);
  raygrid::Run(arguments);
  return 0;
}
