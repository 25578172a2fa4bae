#ifndef RAYGRID_FEATURES_STAR_LOOSE_LATTICE_H
#define RAYGRID_FEATURES_STAR_LOOSE_LATTICE_H

#include <memory>
#include <optional>
#include <vector>

#include "features/star/star_candidates.h"
#include "features/star/star_growth.h"

namespace raygrid {

/// Returns the number of rotations by multiples of 90 degrees under which a
/// lattice of such stars is invariant: 4 (all), 2 (0 and 180 degrees) or 1.
int CountStarSymmetries(int segments);

/// Detects lattices of stars from candidates, for unknown boards and positions
/// on them.
class LooseLatticeFinder {
 public:
  /// segments: segments of each star. max_side: maximum number of columns and
  /// rows.
  LooseLatticeFinder(int segments, int max_side,
                     const DetectionOptions& options);

  /// Grows a lattice around the most certain of some candidates, first without,
  /// then with uncertain stars. Returns an empty list if there is none. For
  /// stars of four segments, also the lattices between them. Columns and rows
  /// start anywhere, in the directions of a board rotated by any number of
  /// quarter turns. Removes candidates on the lattice and those that were
  /// tried. The first stars are searched in an image of 1 / scale of the size,
  /// in which large stars resemble ordinary ones; candidates and lattices are
  /// in pixels of the image.
  std::vector<FeatureLattice> Find(
      const GreyImage& image, const GreyImage& smaller, double scale,
      std::vector<StarCandidate>* candidates) const;

 private:
  Board board_;  // large enough for a seed at its centre
  StarTexture texture_;
  std::vector<SymmetryMask> masks_;  // one for all stars
  DetectionOptions options_;

  struct Seed {
    LocalMapping mapping;
    double total = 0;  // sum of correlations
  };
  std::optional<Seed> SeedAt(const GreyImage& image,
                             const std::vector<StarCandidate>& candidates,
                             const Eigen::Vector2d& center) const;
  std::vector<Seed> FindSeeds(const GreyImage& smaller, double scale,
                              std::vector<StarCandidate>* candidates) const;
  std::vector<Seed> FindSimilarStars(const Seed& seed) const;
  FeatureLattice GrowFrom(const GreyImage& image, const Seed& seed,
                          double alike) const;
};

/// Removes candidates on or near the stars of a lattice.
void RemoveUsedCandidates(const FeatureLattice& lattice,
                          std::vector<StarCandidate>* candidates);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_STAR_LOOSE_LATTICE_H
