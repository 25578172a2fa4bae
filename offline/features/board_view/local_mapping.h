#ifndef RAYGRID_FEATURES_BOARD_VIEW_LOCAL_MAPPING_H
#define RAYGRID_FEATURES_BOARD_VIEW_LOCAL_MAPPING_H

#include <Eigen/Core>
#include <vector>

namespace raygrid {

/// Local mapping from board to image. A board offset s = (u, v), in squares
/// from a feature, is projected to
///   x(s) = center + A s / (1 + h . s) + W m(s),
///   m(s) = (u^2, u v, v^2, u^3, u^2 v, u v^2, v^3):
/// a homography (the paper's H, with the eight parameters center, A and h) plus
/// curvature due to lens distortion.
struct LocalMapping {
  static constexpr int kNumMonomials = 7;

  Eigen::Vector2d center = Eigen::Vector2d::Zero();  ///< pixels
  Eigen::Matrix2d linear = Eigen::Matrix2d::Identity();
  Eigen::Vector2d perspective = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, kNumMonomials> curvature =
      Eigen::Matrix<double, 2, kNumMonomials>::Zero();

  Eigen::Vector2d operator()(const Eigen::Vector2d& offset) const;

  /// Returns the width or height of a square in the image, whichever is
  /// smaller.
  double SpacingPx() const;
  /// Returns the minimum width of a square's inscribed circle in the image,
  /// which is less than the spacing if the square is foreshortened along its
  /// diagonal.
  double CircleWidthPx() const;
};

/// Returns m(s).
Eigen::Matrix<double, LocalMapping::kNumMonomials, 1> CurvatureMonomials(
    const Eigen::Vector2d& offset);

/// A board offset in squares and its pixel.
struct Correspondence {
  Eigen::Vector2d offset;
  Eigen::Vector2d pixel;
  double weight = 1;
};

/// Fits a mapping of the highest degree up to max_degree (1 to 3) that the
/// correspondences determine. Without a correspondence at offset 0, the mapping
/// predicts the feature there. Returns the degree; 0 if there are too few
/// correspondences, or all are collinear.
int FitLocalMapping(const std::vector<Correspondence>& correspondences,
                    int max_degree, LocalMapping* mapping);

/// Fits a mapping whose perspective is that of a homography fitted to the
/// correspondences. More accurate than a polynomial for strong perspective,
/// e.g. if squares fill much of the image. Returns 0 also if no homography
/// fits.
int FitPerspectiveMapping(const std::vector<Correspondence>& correspondences,
                          int max_degree, LocalMapping* mapping);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_LOCAL_MAPPING_H
