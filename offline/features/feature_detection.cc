#include "features/feature_detection.h"

#include <fmt/format.h>

#include <filesystem>
#include <mutex>

#include "dataset/error.h"
#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

void RequireDetectable(const Pattern& pattern) {
  for (const Board& board : pattern.boards)
    if (board.kind != "chessboard")
      throw InputError(fmt::format(
          "board {}: this version detects chessboards, not '{}'; pass "
          "--features with features found elsewhere",
          board.id, board.kind));
}

void RequireOneSize(const std::vector<std::string>& paths,
                    const std::vector<ImageSize>& sizes) {
  for (size_t i = 1; i < sizes.size(); ++i)
    if (sizes[i] != sizes[0])
      throw InputError(fmt::format(
          "{}: {} x {} pixels where {} has {} x {}; calibrate one camera mode "
          "at a time",
          paths[i], sizes[i].width, sizes[i].height, paths[0], sizes[0].width,
          sizes[0].height));
}

}  // namespace

Dataset DetectFeatures(const std::vector<std::string>& image_paths,
                       const Pattern& pattern, int num_threads,
                       const std::function<void(double)>& progress) {
  RequireDetectable(pattern);
  const int count = static_cast<int>(image_paths.size());
  std::vector<ImageSize> sizes(count);
  Dataset dataset;
  dataset.images.resize(count);
  std::mutex mutex;
  int num_done = 0;
  ParallelFor(count, NumThreads(num_threads), [&](int i) {
    const Image image = ReadImage(image_paths[i], true);
    sizes[i] = image.size;
    ImageFeatures& result = dataset.images[i];
    result.image = std::filesystem::path(image_paths[i]).filename().string();
    for (const Board& board : pattern.boards) {
      const std::vector<Feature> found = DetectChessboard(image, board);
      result.features.insert(result.features.end(), found.begin(), found.end());
    }
    const std::lock_guard<std::mutex> lock(mutex);
    if (progress) progress(static_cast<double>(++num_done) / count);
  });
  RequireOneSize(image_paths, sizes);
  if (!sizes.empty()) dataset.image_size = sizes[0];
  return dataset;
}

}  // namespace raygrid
