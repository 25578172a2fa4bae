#ifndef RAYGRID_FEATURES_SQUARES_CORNER_GROWTH_H
#define RAYGRID_FEATURES_SQUARES_CORNER_GROWTH_H

#include <vector>

#include "features/board_view/detection.h"
#include "features/board_view/feature_lattice.h"
#include "features/squares/corner_matching.h"

namespace raygrid {

/// Finds the features of a board that has squares, approximately: each where
/// the image looks like the drawing, near where its neighbours say.
class CornerGrowth {
 public:
  explicit CornerGrowth(const Board& board);

  /// Looks for one feature.
  bool Find(const GreyImage& image, int column, int row,
            const LocalMapping& prediction, double search_squares,
            const PatchCriterion& criterion, FeatureLattice* lattice) const;
  /// Looks for all others, outwards from those that are found.
  void Grow(const GreyImage& image, const PatchCriterion& criterion,
            FeatureLattice* lattice) const;
  /// Looks on, outwards from those that are found, where squares shrink faster
  /// than polynomials predict, as at a fisheye's rim. For boards of evenly
  /// spaced features. Whether it found any.
  bool GrowByRatio(const GreyImage& image, const PatchCriterion& criterion,
                   FeatureLattice* lattice) const;

 private:
  bool Sweep(const GreyImage& image, const PatchCriterion& criterion,
             std::vector<int>* tried_with, FeatureLattice* lattice) const;
  void FindByRatio(const GreyImage& image, int column, int row,
                   const PatchCriterion& criterion,
                   FeatureLattice* lattice) const;

  Board board_;
  // The patches by place. The near ones tell more exactly where a corner is if
  // the neighbours predict the squares' shape badly.
  std::vector<DrawnPatch> patches_, near_patches_;
};

/// Predicts the place of a feature from its neighbours.
bool PredictFeature(const FeatureLattice& lattice, int column, int row,
                    LocalMapping* prediction);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_CORNER_GROWTH_H
