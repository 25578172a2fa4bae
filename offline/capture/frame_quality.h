#ifndef RAYGRID_CAPTURE_FRAME_QUALITY_H
#define RAYGRID_CAPTURE_FRAME_QUALITY_H

#include <Eigen/Core>
#include <vector>

#include "appearance/board_appearance.h"
#include "camera/area.h"
#include "dataset/dataset.h"

namespace raygrid {

/// Image quality of a board: edge width and grey levels. Undetermined values
/// are 0.
struct FrameQuality {
  /// Edge width as the standard deviation of a Gaussian, in pixels, in the
  /// directions of least and most blur. Defocus blurs all directions equally,
  /// motion blurs only edges perpendicular to it.
  double min_spread_px = 0, max_spread_px = 0;
  double white = 0, black = 0;  ///< grey levels, 0 to 255
  double clipped = 0;  ///< fraction of white samples that are saturated
};

/// Measures the edges around a board's features.
///
/// Edges start radially at features, in directions that follow from the board's
/// appearance. Intensities are sampled across each edge; its width follows from
/// the fraction of the black-to-white step within 1 px of the edge. Squared
/// widths along normals n are fitted by n^T S n; the result is the square roots
/// of the eigenvalues of S.
class QualityMeter {
 public:
  /// Throws InputError for boards that cannot be drawn.
  explicit QualityMeter(const Board& board);

  /// levels: row by row, 0 to 255; features: features of this board.
  FrameQuality Measure(const ImageSize& size, const std::vector<float>& levels,
                       const std::vector<Feature>& features) const;

 private:
  struct Edge {
    Eigen::Vector2d center, across;  // from the feature; half a profile, m
  };
  bool IsStep(const Eigen::Vector2d& at, const Edge& edge) const;

  Board board_;
  BoardAppearance appearance_;
  std::vector<std::vector<Edge>> edges_;  // edges by point
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_FRAME_QUALITY_H
