#ifndef RAYGRID_FEATURES_SQUARES_CORNER_MATCHING_H
#define RAYGRID_FEATURES_SQUARES_CORNER_MATCHING_H

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "features/board_view/detection.h"
#include "features/board_view/local_mapping.h"

namespace raygrid {

/// A drawing of the surroundings of a board point, up to `reach` squares in
/// each direction: brightness, row-major.
class DrawnPatch {
 public:
  static constexpr int kSamples = 12;  // along each axis

  /// is_black: whether there is ink at an offset from the point, in squares.
  DrawnPatch(
      double reach,
      const std::function<bool(const Eigen::Vector2d& offset)>& is_black);

  std::vector<Eigen::Vector2d> Offsets() const;
  /// Brightness from 0 (ink) to 1.
  const std::vector<float>& levels() const { return levels_; }

 private:
  double reach_;
  std::vector<float> levels_;
};

struct PatchCorrelation {
  double correlation = -1;  ///< between drawing and image
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

/// Returns the mean grey level of the image around a board offset; nullopt
/// outside the image.
std::optional<double> ComputeMeanGreyLevel(const GreyImage& image,
                                           const LocalMapping& mapping,
                                           const Eigen::Vector2d& offset);

/// Criterion for accepting a match of drawing and image.
struct PatchCriterion {
  double min_correlation = 0.7;
  /// Minimum fraction of the patch that is inside the image; only this region
  /// is compared.
  double min_visible = 0.55;
};

/// Returns the position within search_px of the prediction with the highest
/// correlation of image and patch, to a quarter of a pixel.
PatchCorrelation FindPatch(const GreyImage& image, const DrawnPatch& patch,
                           const LocalMapping& prediction, double search_px,
                           double min_visible);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_SQUARES_CORNER_MATCHING_H
