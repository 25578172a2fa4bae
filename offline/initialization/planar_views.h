#ifndef RAYGRID_INITIALIZATION_PLANAR_VIEWS_H
#define RAYGRID_INITIALIZATION_PLANAR_VIEWS_H

#include <Eigen/Core>
#include <vector>

#include "dataset/dataset.h"

namespace raygrid {

/// The features of one board in one image: nominal positions in the board's
/// plane, and observations.
struct PlanarView {
  std::vector<Eigen::Vector2d> points;
  std::vector<Eigen::Vector2d> pixels;
};

/// Samples views with enough features, without gross outliers, each thinned
/// evenly to a number that is fast to process, and at most max_views of them,
/// evenly spaced.
std::vector<PlanarView> SamplePlanarViews(const Dataset& dataset,
                                          const Pattern& pattern,
                                          size_t max_views);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_PLANAR_VIEWS_H
