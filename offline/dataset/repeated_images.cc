#include "dataset/repeated_images.h"

#include <map>
#include <tuple>

namespace raygrid {
namespace {

constexpr double kSamePx = 1e-3;

using LatticePlace = std::tuple<int, int, int>;

std::map<LatticePlace, Eigen::Vector2d> ByPlace(const ImageFeatures& image) {
  std::map<LatticePlace, Eigen::Vector2d> pixels;
  for (const Feature& f : image.features)
    pixels[{f.board, f.row, f.column}] = f.pixel;
  return pixels;
}

bool AreSame(const std::map<LatticePlace, Eigen::Vector2d>& first,
             const std::map<LatticePlace, Eigen::Vector2d>& second) {
  for (auto a = first.begin(), b = second.begin(); a != first.end(); ++a, ++b)
    if (a->first != b->first || (a->second - b->second).norm() > kSamePx)
      return false;
  return true;
}

}  // namespace

std::vector<std::optional<size_t>> RepeatedImages(const Dataset& dataset) {
  std::vector<std::map<LatticePlace, Eigen::Vector2d>> images;
  std::map<size_t, std::vector<size_t>> by_count;  // those that are no copies
  std::vector<std::optional<size_t>> repeated(dataset.images.size());
  for (size_t i = 0; i < dataset.images.size(); ++i) {
    images.push_back(ByPlace(dataset.images[i]));
    if (images[i].empty()) continue;
    std::vector<size_t>& originals = by_count[images[i].size()];
    for (const size_t original : originals)
      if (AreSame(images[original], images[i])) {
        repeated[i] = original;
        break;
      }
    if (!repeated[i]) originals.push_back(i);
  }
  return repeated;
}

}  // namespace raygrid
