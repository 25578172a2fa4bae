#ifndef RAYGRID_FEATURES_REFINEMENT_FEATURE_REFINEMENT_H
#define RAYGRID_FEATURES_REFINEMENT_FEATURE_REFINEMENT_H

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "features/board_view/detection.h"
#include "features/board_view/local_mapping.h"
#include "features/refinement/symmetry_mask.h"

namespace raygrid {

/// Brings approximate features (within 2 px or a tenth of a square) of one
/// board to the accuracy of the options; every kind of board whose features are
/// point-symmetric: star, chessboard, charuco, aprilgrid. What fails a check is
/// among the rejected.
class FeatureRefiner {
 public:
  FeatureRefiner(const Board& board, const DetectionOptions& options);
  ~FeatureRefiner();

  /// The symmetry masks of the board's features.
  const std::vector<SymmetryMask>& masks() const;

  ImageDetection Refine(const GreyImage& image,
                        const std::vector<Feature>& approximate) const;

  /// Refined ones once more, with mappings known from elsewhere. Those without
  /// one, and those found to be nowhere near, stay as they are; all of them
  /// where the options' refinement does not go by symmetry.
  using MappingCallback =
      std::function<std::optional<LocalMapping>(const Feature&)>;
  std::vector<Feature> RefineWith(const GreyImage& image,
                                  std::vector<Feature> features,
                                  const MappingCallback& tell_mapping) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_FEATURE_REFINEMENT_H
