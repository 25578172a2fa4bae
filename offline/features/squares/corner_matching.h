#ifndef RAYGRID_FEATURES_SQUARES_CORNER_MATCHING_H
#define RAYGRID_FEATURES_SQUARES_CORNER_MATCHING_H

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "features/board_view/detection.h"
#include "features/board_view/local_mapping.h"

namespace raygrid {

/// The surroundings of a place on a board, to each side as far as reach: their
/// brightness, sampled row by row.
class DrawnPatch {
 public:
  static constexpr int kSamples = 12;  // along each axis

  /// is_black tells the ink at an offset. All in squares.
  DrawnPatch(
      double reach,
      const std::function<bool(const Eigen::Vector2d& offset)>& is_black);

  std::vector<Eigen::Vector2d> Offsets() const;
  /// 0 (ink) to 1.
  const std::vector<float>& levels() const { return levels_; }

 private:
  double reach_;
  std::vector<float> levels_;
};

struct PatchMatch {
  double correlation = -1;  ///< of drawing and image
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

/// The mean level of an image around an offset of a mapping; nothing outside
/// the image.
std::optional<double> MeanLevel(const GreyImage& image,
                                const LocalMapping& mapping,
                                const Eigen::Vector2d& offset);

/// How like a drawing the image must be.
struct PatchCriterion {
  double min_correlation = 0.7;
  /// Part of the patch that lies in the image; only that is compared.
  double min_visible = 0.55;
};

/// The place within search_px of a prediction where the image is most like a
/// patch, to a quarter of a pixel.
PatchMatch FindPatch(const GreyImage& image, const DrawnPatch& patch,
                     const LocalMapping& prediction, double search_px,
                     double min_visible);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_CORNER_MATCHING_H
