#ifndef RAYGRID_FEATURES_REFINEMENT_TAG_CORNER_REFINEMENT_H
#define RAYGRID_FEATURES_REFINEMENT_TAG_CORNER_REFINEMENT_H

#include <memory>
#include <vector>

#include "dataset/pattern.h"
#include "features/board_view/detection.h"
#include "features/board_view/local_mapping.h"
#include "features/refinement/symmetry_refinement.h"

namespace raygrid {

struct TagCornerOptions {
  int window_px = 21;
  /// The edges' directions are those of the mapping; otherwise they are
  /// estimated, too.
  bool has_known_edges = false;
  double max_move_px = 2;
  double noise = 0;  ///< of the image, grey levels
  /// How far grey levels are from being proportional to light; 0 if they are:
  /// of light x, from 0 (ink) to 1 (paper), log(1 + (e^tone - 1) x) / tone is
  /// seen. Gamma 2.2 is a tone of about 1. It moves edges towards the ink.
  double tone = 0;
};

/// A corner as it is known before, and how its surroundings are seen.
struct TagCorner {
  int column = 0, row = 0;
  LocalMapping mapping;
};

/// Refines the corners of tags on white paper (AprilGrids without corner
/// squares), which are not point-symmetric: a window of the image is compared
/// with the blurred drawing of the two edges that meet in the corner.
class TagCornerRefiner {
 public:
  /// Throws as BoardAppearance.
  explicit TagCornerRefiner(const Board& board);
  ~TagCornerRefiner();

  /// Minimises the sum of squared differences between image and drawing over
  /// the corner, the directions of its edges, the width of the blur (a
  /// Gaussian), and the levels of ink and paper, by Levenberg and Marquardt's
  /// method. The curvature of the mapping stays fixed. The tags may be drawn
  /// in any quarter turn.
  ///
  /// Not converged: too little of the window in the image, or moved by more
  /// than max_move_px.
  WindowFit Refine(const GreyImage& image, const TagCorner& start,
                   const TagCornerOptions& options) const;

  /// The tone of an image, which its corners have in common; 0 if there are
  /// too few.
  double EstimateTone(const GreyImage& image,
                      const std::vector<TagCorner>& corners,
                      TagCornerOptions options) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_TAG_CORNER_REFINEMENT_H
