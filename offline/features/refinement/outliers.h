#ifndef RAYGRID_FEATURES_REFINEMENT_OUTLIERS_H
#define RAYGRID_FEATURES_REFINEMENT_OUTLIERS_H

#include "features/board_view/detection.h"
#include "features/board_view/feature_lattice.h"

namespace raygrid {

constexpr const char* kNotInLine = "inconsistent with its neighbours";

/// How far a feature may lie from where others say that it is: pixels, and a
/// part of a square's width, one added to the other.
struct Tolerance {
  double px, squares;
};

/// Removes the feature and says why.
void Reject(const Board& board, int column, int row, const std::string& reason,
            FeatureLattice* lattice, ImageDetection* detection);

/// Removes the feature that is farthest from where its neighbours say that it
/// is, until there is none; kNotInLine is the reason. Some are told best by a
/// polynomial, others with perspective, others by the lens that explains the
/// whole lattice: a feature is in line that is where one of them says.
void RejectOutliers(const Board& board, const ImageSize& size,
                    const Tolerance& tolerance, int window_px,
                    FeatureLattice* lattice, ImageDetection* detection);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_OUTLIERS_H
