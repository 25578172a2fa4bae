#ifndef RAYGRID_FEATURES_STAR_STAR_CANDIDATES_H
#define RAYGRID_FEATURES_STAR_STAR_CANDIDATES_H

#include <Eigen/Core>
#include <vector>

#include "features/board_view/detection.h"

namespace raygrid {

/// A point towards which many edges are directed.
struct StarCandidate {
  Eigen::Vector2d pixel;
  double scatter = 1;  ///< of surrounding edges; 0: all meet here
};

/// Returns possible star centres, for any size and pose, least scatter first:
/// junctions as in Foerstner and Guelch (1987). Edges are directed towards a
/// star's centre, however lens and perspective deform its outline.
std::vector<StarCandidate> FindStarCandidates(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_STAR_STAR_CANDIDATES_H
