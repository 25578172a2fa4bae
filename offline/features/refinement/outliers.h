#ifndef RAYGRID_FEATURES_REFINEMENT_OUTLIERS_H
#define RAYGRID_FEATURES_REFINEMENT_OUTLIERS_H

#include "features/board_view/detection.h"
#include "features/board_view/feature_lattice.h"

namespace raygrid {

constexpr const char* kNotCollinear = "inconsistent with its neighbours";

/// Maximum distance of a feature from its prediction: px + squares * width of a
/// square.
struct Tolerance {
  double px, squares;
};

/// Removes the feature and records the reason.
void Reject(const Board& board, int column, int row, const std::string& reason,
            FeatureLattice* lattice, ImageDetection* detection);

/// Repeatedly removes the feature with the largest deviation, with the reason
/// kNotCollinear. Features are predicted from their neighbours by a polynomial
/// and by a mapping with perspective, and by a lens model of the whole lattice:
/// a feature is an inlier if one prediction is within the tolerance.
void RejectOutliers(const Board& board, const ImageSize& size,
                    const Tolerance& tolerance, int window_px,
                    FeatureLattice* lattice, ImageDetection* detection);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_OUTLIERS_H
