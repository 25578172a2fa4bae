#include "initialization/planar_views.h"

#include <algorithm>

namespace raygrid {
namespace {

constexpr size_t kMinFeatures = 8, kMaxFeatures = 80;  // of a view

PlanarView ViewOf(const ImageFeatures& image, const Board& board) {
  const std::vector<Eigen::Vector3d> nominal = board.NominalPoints();
  PlanarView view;
  const size_t step = image.features.size() / kMaxFeatures + 1;
  for (size_t i = 0; i < image.features.size(); i += step) {
    const Feature& feature = image.features[i];
    if (feature.board != board.id) continue;
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
      PlanarView view = ViewOf(image, board);
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
