#include "features/pattern_detector.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <mutex>
#include <new>
#include <opencv2/core.hpp>
#include <optional>
#include <tuple>

#include "dataset/error.h"
#include "dataset/image_header.h"
#include "dataset/image_memory_budget.h"
#include "dataset/parallel_for.h"
#include "dataset/text_encoding.h"
#include "features/board_view/locators.h"
#include "features/board_view/low_contrast.h"
#include "features/refinement/feature_refinement.h"
#include "features/star/star_detection.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void ThrowUnsupportedTarget(const Board& board) {
  throw InputError(
      fmt::format("board {}: targets of kind '{}' cannot be detected; pass "
                  "features from another detector with --features",
                  board.id, board.kind));
}

Locator MakeLocator(const Board& board) {
  using Make = Locator (*)(const Board&);
  constexpr Make kInOrderOfKinds[] = {
#define RAYGRID_TARGET_KIND(Name) &Make##Name##Locator,
#include "dataset/kinds/kind_list.inc"
#undef RAYGRID_TARGET_KIND
  };
  size_t i = 0;
  for (const auto& kind : TargetKinds()) {
    if (kind.get() == &KindOf(board)) return kInOrderOfKinds[i](board);
    ++i;
  }
  ThrowUnsupportedTarget(board);
}

void Append(ImageDetection part, ImageDetection* whole) {
  const auto append = [](auto&& from, auto* to) {
    to->insert(to->end(), from.begin(), from.end());
  };
  append(part.features, &whole->features);
  append(part.rejected, &whole->rejected);
  append(part.warnings, &whole->warnings);
}

bool HasLowerIndex(const Feature& a, const Feature& b) {
  return std::tie(a.board, a.row, a.column) <
         std::tie(b.board, b.row, b.column);
}

void RequireInRange(const DetectionOptions& options) {
  if (options.window_px < 5 || options.window_px > 101 ||
      options.window_px % 2 == 0)
    throw InputError(
        fmt::format("window of {} px: must be an odd number from 5 to 101",
                    options.window_px));
}

}  // namespace

Locator MakePointsLocator(const Board& board) { ThrowUnsupportedTarget(board); }

struct PatternDetector::Data {
  struct SingleBoard {
    Locator locate;
    std::unique_ptr<FeatureRefiner> refiner;
  };
  std::unique_ptr<StarDetector> stars;
  std::vector<SingleBoard> boards;

  ImageDetection Detect(const GreyImage& image) const;
};

PatternDetector::PatternDetector(const Pattern& pattern,
                                 const DetectionOptions& options)
    : data_(std::make_unique<Data>()) {
  RequireInRange(options);
  Pattern stars;
  for (const Board& board : pattern.boards) {
    Locator locate = MakeLocator(board);
    if (!locate) {
      stars.boards.push_back(board);
      continue;
    }
    data_->boards.push_back(
        {std::move(locate), std::make_unique<FeatureRefiner>(board, options)});
  }
  if (!stars.boards.empty())
    data_->stars = std::make_unique<StarDetector>(stars, options);
}

PatternDetector::~PatternDetector() = default;

ImageDetection PatternDetector::Data::Detect(const GreyImage& image) const {
  ImageDetection detection;
  if (stars) detection = stars->Detect(image);
  for (const SingleBoard& board : boards) {
    ImageDetection located = board.locate(image);
    if (!located.features.empty())
      Append(board.refiner->Refine(image, located.features), &detection);
    located.features.clear();
    Append(std::move(located), &detection);
  }
  std::stable_sort(detection.features.begin(), detection.features.end(),
                   HasLowerIndex);
  return detection;
}

ImageDetection PatternDetector::Detect(const GreyImage& image) const {
  if (!IsLargeEnough(image.size)) return {};
  ImageDetection detection;
  if (!IsPureNoise(image)) {
    detection = data_->Detect(image);
    if (detection.features.empty())
      if (const auto amplified = AmplifyLowContrast(image))
        detection = data_->Detect(*amplified);
  }
  if (detection.features.empty() && HasLowContrast(image))
    detection.warnings.push_back(
        "too little contrast (below 8 grey levels, or below the noise); check "
        "light, exposure and lens cap");
  if (image.was_mosaic)
    detection.warnings.push_back(
        "raw Bayer image: converted to grey after white balancing");
  return detection;
}

namespace {

// Result for one image of a folder: the detection, or the reason of the
// failure.
struct Outcome {
  std::optional<DetectedImage> seen;
  std::string failure;
  bool is_turned = false;  // the EXIF orientation is not upright
};

class ImageReader {
 public:
  ImageReader(const Pattern& pattern, const DetectionOptions& options,
              const DetectionCache* cache)
      : pattern_(pattern),
        options_(options),
        detector_(pattern, options),
        cache_(cache) {}

  Outcome Read(const std::string& path) const {
    try {
      const std::string bytes = ReadImageFile(path);
      const ImageHeader header = ParseImageHeader(path, bytes);
      if (!IsLargeEnough(header.size))
        throw InputError(
            fmt::format("{}: {} x {} pixels, too small to show a board", path,
                        header.size.width, header.size.height));
      return {DetectInImage(path, bytes, header.size), "",
              header.orientation != 1};
    } catch (const InputError& error) {
      return {std::nullopt, error.what(), false};
    } catch (const std::bad_alloc&) {
      return {std::nullopt, path + ": out of memory", false};
    } catch (const cv::Exception& error) {
      return {std::nullopt,
              fmt::format("{}: cannot be processed ({})", path, error.err),
              false};
    }
  }

 private:
  DetectedImage DetectInImage(const std::string& path, const std::string& bytes,
                              const ImageSize& size) const {
    std::string key;
    if (cache_) {
      key = DetectionCache::Key(bytes, pattern_, options_);
      if (const auto seen = cache_->Find(key)) return *seen;
    }
    const ImageMemoryBudget room(size);
    const GreyImage image = MakeGreyImage(DecodeGreyLevels(path, bytes));
    const DetectedImage seen = {image.size, detector_.Detect(image)};
    if (cache_) cache_->Store(key, seen);
    return seen;
  }

  const Pattern& pattern_;
  const DetectionOptions& options_;
  PatternDetector detector_;
  const DetectionCache* cache_;
};

std::string FileName(const std::string& path) {
  return fs::path(path).filename().string();
}

// Throws if images have the same file name, which identifies them in all files.
void RequireDistinctNames(const std::vector<std::string>& paths) {
  std::map<std::string, std::string> path_by_name;
  for (const std::string& path : paths) {
    RequireStorableName("image", FileName(path));
    const auto [place, is_new] = path_by_name.emplace(FileName(path), path);
    if (!is_new)
      throw InputError(
          fmt::format("{} and {} have the same name; rename or remove one",
                      place->second, path));
  }
}

// Returns the most frequent image size. Throws if there is none.
ImageSize ComputeCommonSize(const std::vector<std::string>& paths,
                            const std::vector<Outcome>& outcomes) {
  std::map<std::pair<int, int>, int> count;
  int first = -1;
  for (size_t i = 0; i < paths.size(); ++i) {
    if (!outcomes[i].seen) continue;
    ++count[{outcomes[i].seen->size.width, outcomes[i].seen->size.height}];
    if (first < 0) first = static_cast<int>(i);
  }
  if (first < 0)
    throw InputError(
        paths.size() == 1
            ? outcomes[0].failure
            : fmt::format("{} (and none of the other {} images can be read)",
                          outcomes[0].failure, paths.size() - 1));
  const auto most = std::max_element(
      count.begin(), count.end(),
      [](const auto& a, const auto& b) { return a.second < b.second; });
  for (const auto& [size, number] : count) {
    if (number < most->second || size == most->first) continue;
    const ImageSize here = outcomes[first].seen->size;
    for (size_t i = first; i < paths.size(); ++i)
      if (outcomes[i].seen && outcomes[i].seen->size != here)
        throw InputError(fmt::format(
            "image sizes differ: {} has {} x {} pixels, {} has {} x {}; "
            "calibrate each camera and sensor mode separately",
            paths[i], outcomes[i].seen->size.width,
            outcomes[i].seen->size.height, paths[first], here.width,
            here.height));
  }
  return {most->first.first, most->first.second};
}

// Removes the path at the start of an error message.
std::string RemovePath(const std::string& failure, const std::string& path) {
  const std::string start = path + ": ";
  return failure.compare(0, start.size(), start) == 0
             ? failure.substr(start.size())
             : failure;
}

FolderDetection Collect(const std::vector<std::string>& paths,
                        std::vector<Outcome> outcomes) {
  FolderDetection folder;
  if (paths.empty()) return folder;
  const ImageSize size = ComputeCommonSize(paths, outcomes);
  folder.dataset.image_size = size;
  for (size_t i = 0; i < paths.size(); ++i) {
    std::optional<DetectedImage>& seen = outcomes[i].seen;
    if (!seen) {
      folder.skipped.push_back(
          {paths[i], RemovePath(outcomes[i].failure, paths[i])});
    } else if (seen->size != size) {
      folder.skipped.push_back(
          {paths[i], fmt::format("{} x {} pixels, but most images have {} x {}",
                                 seen->size.width, seen->size.height,
                                 size.width, size.height)});
    } else {
      folder.dataset.images.push_back(
          {FileName(paths[i]), seen->detection.features});
      folder.paths.push_back(paths[i]);
      if (outcomes[i].is_turned) folder.turned.push_back(FileName(paths[i]));
      folder.images.push_back(std::move(seen->detection));
    }
  }
  return folder;
}

}  // namespace

std::vector<std::string> SummarizeWarnings(const FolderDetection& folder) {
  std::map<std::string, std::pair<int, std::string>> seen;  // count, first
  for (size_t i = 0; i < folder.images.size(); ++i) {
    const ImageDetection& image = folder.images[i];
    std::vector<std::string> warnings = image.warnings;
    if (image.features.empty() && !image.rejected.empty())
      warnings.push_back("features rejected: " + image.rejected[0].reason);
    for (const std::string& warning : warnings) {
      auto& [count, first] = seen[warning];
      if (count++ == 0) first = FileName(folder.paths[i]);
    }
  }
  std::vector<std::string> summary;
  for (const auto& [warning, where] : seen)
    summary.push_back(where.first == 1
                          ? fmt::format("{} ({})", warning, where.second)
                          : fmt::format("{} ({} images, first {})", warning,
                                        where.first, where.second));
  return summary;
}

FolderDetection DetectFeatures(const std::vector<std::string>& image_paths,
                               const Pattern& pattern,
                               const DetectionOptions& options,
                               const DetectionCache* cache, int num_threads,
                               const std::function<void(double)>& progress) {
  const ImageReader reader(pattern, options, cache);
  RequireDistinctNames(image_paths);
  const int count = static_cast<int>(image_paths.size());
  std::vector<Outcome> outcomes(count);
  std::mutex mutex;
  int num_done = 0;
  ParallelFor(count, NumThreads(num_threads), [&](int i) {
    outcomes[i] = reader.Read(image_paths[i]);
    const std::lock_guard<std::mutex> lock(mutex);
    if (progress) progress(static_cast<double>(++num_done) / count);
  });
  if (cache) cache->Trim();
  return Collect(image_paths, std::move(outcomes));
}

Dataset DetectFeatures(const std::vector<std::string>& image_paths,
                       const Pattern& pattern, int num_threads,
                       const std::function<void(double)>& progress) {
  return DetectFeatures(image_paths, pattern, {}, nullptr, num_threads,
                        progress)
      .dataset;
}

}  // namespace raygrid
