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

/// Samples at most max_views evenly spaced views with enough features. Gross
/// outliers are removed, and the remaining features of each view are subsampled
/// evenly, to limit the run time.
std::vector<PlanarView> SamplePlanarViews(const Dataset& dataset,
                                          const Pattern& pattern,
                                          size_t max_views);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_PLANAR_VIEWS_H
