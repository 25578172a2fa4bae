#ifndef RAYGRID_FEATURES_STAR_STAR_CANDIDATES_H
#define RAYGRID_FEATURES_STAR_STAR_CANDIDATES_H

#include <Eigen/Core>
#include <vector>

#include "features/board_view/detection.h"

namespace raygrid {

/// A point towards which many edges are directed.
struct StarCandidate {
  Eigen::Vector2d pixel;
  double scatter = 1;  ///< scatter of surrounding edges; 0: all intersect here
};

/// Returns possible star centres for any size and pose, in ascending order of
/// scatter: junctions as in Foerstner and Guelch (1987). Lens distortion and
/// perspective deform a star's outline, but its edges still point at the
/// centre.
std::vector<StarCandidate> FindStarCandidates(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_STAR_STAR_CANDIDATES_H
