#ifndef RAYGRID_FEATURES_STAR_LOOSE_LATTICE_H
#define RAYGRID_FEATURES_STAR_LOOSE_LATTICE_H

#include <memory>
#include <optional>
#include <vector>

#include "features/star/star_candidates.h"
#include "features/star/star_growth.h"

namespace raygrid {

/// The number of quarter turns by which a lattice of such stars looks the same:
/// 4 for all, 2 for 0 and 2, 1 for none but 0.
int FindStarSymmetries(int segments);

/// Stars without a board: finds lattices of them where candidates are, whatever
/// board they are on and wherever on it.
class LooseLatticeFinder {
 public:
  /// A finder for boards of such stars with at most this many columns and rows.
  LooseLatticeFinder(int segments, int max_side,
                     const DetectionOptions& options);

  /// The lattice around the surest of some of the candidates, first without,
  /// then with doubtful stars; nothing if there is none. Of stars of four
  /// segments the lattices between them too. Its places count from
  /// anywhere, right and down as on a board that is turned by some quarter
  /// turns. Candidates on it and those that were tried are removed. The first
  /// stars are sought in a smaller image, of 1 / scale of the size, in which
  /// large ones hardly differ from ordinary ones; candidates and lattices are
  /// in the image's pixels.
  std::vector<FeatureLattice> Find(
      const GreyImage& image, const GreyImage& smaller, double scale,
      std::vector<StarCandidate>* candidates) const;

 private:
  Board board_;  // large enough wherever the first star is
  StarTexture texture_;
  std::vector<SymmetryMask> masks_;  // one for all
  DetectionOptions options_;

  struct Seed {
    LocalMapping mapping;
    double total = 0;  // of correlations
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

/// Removes candidates on the stars of a lattice or near to them.
void RemoveExplained(const FeatureLattice& lattice,
                     std::vector<StarCandidate>* candidates);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_STAR_LOOSE_LATTICE_H
