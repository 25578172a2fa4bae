#ifndef RAYGRID_FEATURES_BOARD_VIEW_LOCAL_MAPPING_H
#define RAYGRID_FEATURES_BOARD_VIEW_LOCAL_MAPPING_H

#include <Eigen/Core>
#include <vector>

namespace raygrid {

/// How a small part of a board appears in the image. Offset s = (u, v) on the
/// board, in squares from a feature, is seen at
///   x(s) = center + A s / (1 + h . s) + W m(s),
///   m(s) = (u^2, u v, v^2, u^3, u^2 v, u v^2, v^3):
/// a homography (the paper's H, its eight parameters being center, A and h),
/// and the curvature that the lens adds to it.
struct LocalMapping {
  static constexpr int kNumMonomials = 7;

  Eigen::Vector2d center = Eigen::Vector2d::Zero();  ///< pixels
  Eigen::Matrix2d linear = Eigen::Matrix2d::Identity();
  Eigen::Vector2d perspective = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, kNumMonomials> curvature =
      Eigen::Matrix<double, 2, kNumMonomials>::Zero();

  Eigen::Vector2d operator()(const Eigen::Vector2d& offset) const;

  /// A square's width or height in the image, the smaller one.
  double SpacingPx() const;
  /// How wide a circle in a square appears where it is narrowest: less than the
  /// spacing where a square is foreshortened along its diagonal.
  double CircleWidthPx() const;
};

/// m(s).
Eigen::Matrix<double, LocalMapping::kNumMonomials, 1> CurvatureMonomials(
    const Eigen::Vector2d& offset);

/// A place on the board, as an offset in squares, and where it is seen.
struct Correspondence {
  Eigen::Vector2d offset;
  Eigen::Vector2d pixel;
  double weight = 1;
};

/// The mapping nearest to correspondences: a polynomial of the highest degree,
/// at most max_degree (1 to 3), that they determine well; without the offset 0
/// it predicts that feature. Returns the degree; 0 if there are too few, or all
/// on a line.
int FitLocalMapping(const std::vector<Correspondence>& correspondences,
                    int max_degree, LocalMapping* mapping);

/// Fits a mapping with the perspective of the homography nearest to the
/// correspondences: where this is strong, as in squares that fill much of an
/// image, it predicts better than a polynomial. 0, too, if no homography comes
/// near.
int FitPerspectiveMapping(const std::vector<Correspondence>& correspondences,
                          int max_degree, LocalMapping* mapping);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_LOCAL_MAPPING_H
