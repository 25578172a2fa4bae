#include "initialization/planar_views.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "initialization/median.h"

namespace raygrid {
namespace {

constexpr size_t kMinFeatures = 8, kMaxFeatures = 80;  // per view

// Removes gross outliers, which are far from the midpoint of their neighbours
// on either side. This may also remove inliers at an edge next to an outlier.
std::vector<Feature> RemoveOutliers(const std::vector<Feature>& features) {
  constexpr double kInlierLimitPerMedian = 8, kMinInlierLimitPx = 2;
  std::map<std::pair<int, int>, const Feature*> at;
  for (const Feature& feature : features)
    at[{feature.column, feature.row}] = &feature;
  const auto find = [&at](int column, int row) -> const Feature* {
    const auto found = at.find({column, row});
    return found == at.end() ? nullptr : found->second;
  };
  std::vector<double> all_distances;
  std::vector<std::optional<double>> distance(features.size());
  for (size_t i = 0; i < features.size(); ++i) {
    const Feature& f = features[i];
    std::vector<double> distances;
    for (const auto& [x, y] : {std::pair(1, 0), std::pair(0, 1),
                               std::pair(1, 1), std::pair(1, -1)}) {
      const Feature* before = find(f.column - x, f.row - y);
      const Feature* after = find(f.column + x, f.row + y);
      if (before && after)
        distances.push_back(
            ((before->pixel + after->pixel) / 2 - f.pixel).norm());
    }
    if (distances.empty()) continue;
    distance[i] = Median(distances);
    all_distances.push_back(*distance[i]);
  }
  if (all_distances.empty()) return features;
  const double limit_px =
      kMinInlierLimitPx + kInlierLimitPerMedian * Median(all_distances);
  std::vector<Feature> consistent;
  for (size_t i = 0; i < features.size(); ++i)
    if (!distance[i] || *distance[i] <= limit_px)
      consistent.push_back(features[i]);
  return consistent;
}

PlanarView MakePlanarView(const ImageFeatures& image, const Board& board) {
  std::vector<Feature> features;
  for (const Feature& feature : image.features)
    if (feature.board == board.id) features.push_back(feature);
  features = RemoveOutliers(features);
  const std::vector<Eigen::Vector3d> nominal = board.NominalPoints();
  PlanarView view;
  const size_t step = features.size() / kMaxFeatures + 1;
  for (size_t i = 0; i < features.size(); i += step) {
    const Feature& feature = features[i];
    view.points.push_back(
        nominal[board.PointIndex(feature.column, feature.row)].head<2>());
    view.pixels.push_back(feature.pixel);
  }
  return view;
}

}  // namespace

std::vector<PlanarView> SamplePlanarViews(const Dataset& dataset,
                                          const Pattern& pattern,
                                          size_t max_views) {
  std::vector<PlanarView> all;
  for (const ImageFeatures& image : dataset.images) {
    for (const Board& board : pattern.boards) {
      PlanarView view = MakePlanarView(image, board);
      if (view.points.size() >= kMinFeatures) all.push_back(std::move(view));
    }
  }
  std::vector<PlanarView> sample;
  const size_t count = std::min(max_views, all.size());
  for (size_t i = 0; i < count; ++i)
    sample.push_back(all[i * all.size() / count]);
  return sample;
}

}  // namespace raygrid
