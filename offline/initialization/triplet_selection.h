#ifndef RAYGRID_INITIALIZATION_TRIPLET_SELECTION_H
#define RAYGRID_INITIALIZATION_TRIPLET_SELECTION_H

#include <array>
#include <cstdint>
#include <vector>

#include "initialization/dense_matches.h"
#include "initialization/planar_pose_solver.h"

namespace raygrid {

/// Three views whose relative poses are known.
struct SolvedTriplet {
  std::array<int, 3> views;  ///< indices
  size_t num_matches = 0;
  ThreeViews poses;
  ThreeViewsFit fit;
};

struct TripletOptions {
  int max_triplets = 500;  ///< that are sampled
  uint64_t seed = 0;
  int num_threads = 1;
};

/// Samples triplets that overlap, solves them, and returns the count best ones,
/// the best first. The paper takes the one with most matches; but it may be of
/// nearly parallel boards. So all are solved linearly, those that promise most
/// are refined, and the best has the least uncertain centre, to which overlap,
/// tilts, and how well the points agree all contribute.
std::vector<SolvedTriplet> SelectTriplets(const std::vector<DenseView>& views,
                                          const PixelLattice& lattice,
                                          int count,
                                          const TripletOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_TRIPLET_SELECTION_H
