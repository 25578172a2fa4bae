#ifndef RAYGRID_FEATURES_STAR_STAR_CANDIDATES_H
#define RAYGRID_FEATURES_STAR_STAR_CANDIDATES_H

#include <Eigen/Core>
#include <vector>

#include "features/board_view/detection.h"

namespace raygrid {

/// A place at which many edges point.
struct StarCandidate {
  Eigen::Vector2d pixel;
  double scatter = 1;  ///< of the edges around it; 0: all point at it
};

/// Places where stars may be, of any size and seen from anywhere, those with
/// the least scatter first. Junctions as Foerstner and Guelch (1987) find them:
/// edges keep pointing at a star's centre however lens and perspective bend its
/// outline.
std::vector<StarCandidate> FindStarCandidates(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_STAR_STAR_CANDIDATES_H
