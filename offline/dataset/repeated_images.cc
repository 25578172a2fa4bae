#include "dataset/repeated_images.h"

#include <map>
#include <tuple>
#include <utility>

namespace raygrid {
namespace {

constexpr double kMaxSameFeatureDistancePx = 1e-3,
                 kMaxRecompressedDistancePx = 0.05;

using LatticePosition = std::tuple<int, int, int>;
using PixelsByPosition = std::map<LatticePosition, Eigen::Vector2d>;

PixelsByPosition IndexByPosition(const ImageFeatures& image) {
  PixelsByPosition pixels;
  for (const Feature& f : image.features)
    pixels[{f.board, f.row, f.column}] = f.pixel;
  return pixels;
}

// Whether two images with equal numbers of features have the same ones.
bool HaveSameFeatures(const PixelsByPosition& first,
                      const PixelsByPosition& second) {
  for (auto a = first.begin(), b = second.begin(); a != first.end(); ++a, ++b)
    if (a->first != b->first ||
        (a->second - b->second).norm() > kMaxSameFeatureDistancePx)
      return false;
  return true;
}

}  // namespace

std::vector<std::optional<size_t>> RepeatedImages(const Dataset& dataset) {
  std::vector<PixelsByPosition> images;
  std::map<size_t, std::vector<size_t>> images_by_count;  // without duplicates
  std::vector<std::optional<size_t>> repeated(dataset.images.size());
  for (size_t i = 0; i < dataset.images.size(); ++i) {
    images.push_back(IndexByPosition(dataset.images[i]));
    if (images[i].empty()) continue;
    std::vector<size_t>& originals = images_by_count[images[i].size()];
    for (const size_t original : originals)
      if (HaveSameFeatures(images[original], images[i])) {
        repeated[i] = original;
        break;
      }
    if (!repeated[i]) originals.push_back(i);
  }
  return repeated;
}

std::optional<ImagePair> FindSharedImage(const Dataset& first,
                                         const Dataset& second) {
  std::map<size_t, std::vector<std::pair<std::string, PixelsByPosition>>>
      images_by_count;
  std::map<std::string, PixelsByPosition> pixels_by_name;
  for (const ImageFeatures& image : first.images) {
    const PixelsByPosition pixels = IndexByPosition(image);
    if (pixels.empty()) continue;
    images_by_count[pixels.size()].emplace_back(image.image, pixels);
    pixels_by_name.emplace(image.image, pixels);
  }
  std::optional<ImagePair> same_name_pair;
  size_t num_near = 0, num_common = 0;
  for (const ImageFeatures& image : second.images) {
    const PixelsByPosition pixels = IndexByPosition(image);
    if (pixels.empty()) continue;
    for (const auto& [name, others] : images_by_count[pixels.size()])
      if (HaveSameFeatures(others, pixels)) return ImagePair{name, image.image};
    const auto other = pixels_by_name.find(image.image);
    if (other == pixels_by_name.end()) continue;
    if (!same_name_pair) same_name_pair = {image.image, image.image};
    for (const auto& [place, pixel] : pixels) {
      const auto found = other->second.find(place);
      if (found == other->second.end()) continue;
      ++num_common;
      num_near += (found->second - pixel).norm() < kMaxRecompressedDistancePx;
    }
  }
  return 2 * num_near > num_common ? same_name_pair : std::nullopt;
}

}  // namespace raygrid
