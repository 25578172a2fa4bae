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

/// Refines approximate features (within 2 px or a tenth of a square) of one
/// board, of any kind with point-symmetric features: star, chessboard, charuco,
/// aprilgrid. Features that fail a check are rejected.
class FeatureRefiner {
 public:
  FeatureRefiner(const Board& board, const DetectionOptions& options);
  ~FeatureRefiner();

  /// The symmetry masks of the board's features.
  const std::vector<SymmetryMask>& masks() const;

  ImageDetection Refine(const GreyImage& image,
                        const std::vector<Feature>& approximate) const;

  /// Refines features again with given mappings. Features without a mapping,
  /// and features whose refinement fails, are unchanged. If the method in the
  /// options is not based on symmetry, all features are unchanged.
  using MappingCallback =
      std::function<std::optional<LocalMapping>(const Feature&)>;
  std::vector<Feature> RefineWith(const GreyImage& image,
                                  std::vector<Feature> features,
                                  const MappingCallback& get_mapping) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_FEATURE_REFINEMENT_H
