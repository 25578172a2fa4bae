#ifndef RAYGRID_INITIALIZATION_PLANAR_VIEWS_H
#define RAYGRID_INITIALIZATION_PLANAR_VIEWS_H

#include <Eigen/Core>
#include <vector>

#include "dataset/dataset.h"

namespace raygrid {

/// The features of one board in one image: where they are nominally in the
/// board's plane, and in the image.
struct PlanarView {
  std::vector<Eigen::Vector2d> points;
  std::vector<Eigen::Vector2d> pixels;
};

/// Views of enough features, without gross outliers, each thinned to a number
/// that is quick, evenly in its order; and of the views, no more than
/// max_views, evenly.
std::vector<PlanarView> SamplePlanarViews(const Dataset& dataset,
                                          const Pattern& pattern,
                                          size_t max_views);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_PLANAR_VIEWS_H
