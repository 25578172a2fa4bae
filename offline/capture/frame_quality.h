#ifndef RAYGRID_CAPTURE_FRAME_QUALITY_H
#define RAYGRID_CAPTURE_FRAME_QUALITY_H

#include <Eigen/Core>
#include <vector>

#include "appearance/board_appearance.h"
#include "camera/area.h"
#include "dataset/dataset.h"

namespace raygrid {

/// How a board looks in an image: its edges and its paper. What no feature told
/// is 0.
struct FrameQuality {
  /// How far edges are spread, as the standard deviation of a Gaussian, in
  /// pixels: across edges that are blurred least, and most. A lens out of focus
  /// spreads all alike, motion those that it crosses.
  double least_spread_px = 0, most_spread_px = 0;
  double white = 0, black = 0;  ///< grey levels, 0 to 255
  double clipped = 0;  ///< part of the white that is as white as can be
};

/// Measures the edges around a board's features.
///
/// Edges leave features radially, wherever the drawing says. Across each the
/// levels are sampled. The part of the step from black to white that lies
/// within 1 px on both sides of the edge tells its spread. The squares of the
/// spreads by the edges' normals n are fitted by n^T S n; the roots of its
/// eigenvalues are told.
class QualityMeter {
 public:
  /// Throws InputError: boards that cannot be drawn.
  explicit QualityMeter(const Board& board);

  /// levels    row by row, 0 to 255
  /// features  of this board
  FrameQuality Measure(const ImageSize& size, const std::vector<float>& levels,
                       const std::vector<Feature>& features) const;

 private:
  struct Edge {
    Eigen::Vector2d middle, across;  // from the feature; half a profile, metres
  };
  bool IsStep(const Eigen::Vector2d& at, const Edge& edge) const;

  Board board_;
  BoardAppearance appearance_;
  std::vector<std::vector<Edge>> edges_;  // by point
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_FRAME_QUALITY_H
