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
  /// Whether the edge directions of the mapping are accurate; otherwise they
  /// are estimated, too.
  bool has_known_edges = false;
  double max_move_px = 2;
  double noise = 0;  ///< standard deviation, grey levels
  /// Nonlinearity of the grey levels; 0: linear. For light x from 0 (ink) to 1
  /// (paper), log(1 + (e^tone - 1) x) / tone is recorded. A gamma of 2.2
  /// corresponds to about 1. It shifts edges towards the ink.
  double tone = 0;
};

/// An approximate corner and its local mapping.
struct TagCorner {
  int column = 0, row = 0;
  LocalMapping mapping;
};

/// Refines the corners of tags on white paper (AprilGrids without corner
/// squares), which are not point-symmetric, by comparing a window of the image
/// with a blurred rendering of the two edges that meet at the corner.
class TagCornerRefiner {
 public:
  /// Throws like BoardAppearance.
  explicit TagCornerRefiner(const Board& board);
  ~TagCornerRefiner();

  /// Minimizes the sum of squared differences between image and rendering over
  /// the corner, the directions of its edges, the width of the Gaussian blur,
  /// and the grey levels of ink and paper, by Levenberg-Marquardt. The
  /// curvature of the mapping is fixed. Tags may be rotated by any multiple of
  /// 90 degrees.
  ///
  /// is_converged is false if too little of the window is in the image, or if
  /// the corner moves by more than max_move_px.
  WindowFit Refine(const GreyImage& image, const TagCorner& start,
                   const TagCornerOptions& options) const;

  /// Estimates the tone of an image as the median over its corners; 0 if there
  /// are too few.
  double EstimateTone(const GreyImage& image,
                      const std::vector<TagCorner>& corners,
                      TagCornerOptions options) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_TAG_CORNER_REFINEMENT_H
