#ifndef RAYGRID_INITIALIZATION_TRIPLET_SELECTION_H
#define RAYGRID_INITIALIZATION_TRIPLET_SELECTION_H

#include <array>
#include <cstdint>
#include <vector>

#include "initialization/dense_matches.h"
#include "initialization/planar_pose_solver.h"

namespace raygrid {

/// Three views with estimated relative poses.
struct SolvedTriplet {
  std::array<int, 3> views;  ///< indices
  size_t num_matches = 0;
  ThreeViews poses;
  ThreeViewsFit fit;
};

struct TripletOptions {
  int max_triplets = 500;  ///< number sampled
  uint64_t seed = 0;
  int num_threads = 1;
};

/// Samples overlapping triplets, solves them, and returns the count best ones,
/// best first. The paper chooses the triplet with most matches, whose boards
/// may be nearly parallel. Instead, all triplets are solved linearly. The most
/// promising ones are refined and ranked by the uncertainty of the camera
/// centre, which depends on overlap, tilt and residuals.
std::vector<SolvedTriplet> SelectTriplets(const std::vector<DenseView>& views,
                                          const PixelLattice& lattice,
                                          int count,
                                          const TripletOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_TRIPLET_SELECTION_H
