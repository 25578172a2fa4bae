#ifndef RAYGRID_FEATURES_SQUARES_CORNER_GROWTH_H
#define RAYGRID_FEATURES_SQUARES_CORNER_GROWTH_H

#include <vector>

#include "features/board_view/detection.h"
#include "features/board_view/feature_lattice.h"
#include "features/squares/corner_matching.h"

namespace raygrid {

/// Detects the features of a board with squares approximately, by correlation
/// with a drawing of the corner near its prediction from neighbours.
class CornerGrowth {
 public:
  explicit CornerGrowth(const Board& board);

  /// Searches for one feature; returns whether it was found.
  bool Find(const GreyImage& image, int column, int row,
            const LocalMapping& prediction, double search_squares,
            const PatchCriterion& criterion, FeatureLattice* lattice) const;
  /// Searches for all other features, starting next to those already detected.
  void Grow(const GreyImage& image, const PatchCriterion& criterion,
            FeatureLattice* lattice) const;
  /// Extends the lattice where squares shrink faster than polynomials predict,
  /// e.g. near the edge of a fisheye image. For boards with evenly spaced
  /// features. Returns whether any feature was found.
  bool GrowWithSpacingRatio(const GreyImage& image,
                            const PatchCriterion& criterion,
                            FeatureLattice* lattice) const;

 private:
  bool Sweep(const GreyImage& image, const PatchCriterion& criterion,
             std::vector<int>* tried_with, FeatureLattice* lattice) const;
  void FindWithSpacingRatio(const GreyImage& image, int column, int row,
                            const PatchCriterion& criterion,
                            FeatureLattice* lattice) const;

  Board board_;
  // One patch per feature. The smaller near_patches_ locate a corner more
  // accurately where the shape of squares is predicted poorly.
  std::vector<DrawnPatch> patches_, near_patches_;
};

/// Predicts the position of a feature from its neighbours.
bool PredictFeature(const FeatureLattice& lattice, int column, int row,
                    LocalMapping* prediction);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_CORNER_GROWTH_H
