#ifndef RAYGRID_FEATURES_BOARD_VIEW_LATTICE_LENS_H
#define RAYGRID_FEATURES_BOARD_VIEW_LATTICE_LENS_H

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "dataset/dataset.h"
#include "features/board_view/local_mapping.h"

namespace raygrid {

/// A radial lens model and the pose of a planar board, fitted to the features
/// of one lattice: a direction at the angle t from the axis is projected to the
/// distance f (t + k1 t^3 + k2 t^5) from the centre. It predicts missing
/// features within and beyond the lattice, as around large tags near a
/// fisheye's edge, to about a pixel, as real lenses are not exactly radial.
class LatticeLens {
 public:
  /// Returns nullopt for fewer than 20 features, or if half of them have
  /// residuals above a pixel.
  static std::optional<LatticeLens> Fit(const std::vector<Feature>& features,
                                        const ImageSize& size);

  /// Projects a point of the lattice, in squares; nullopt if its angle from the
  /// axis exceeds the largest angle of a feature by a fifth.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector2d& place) const;
  /// Returns the local mapping within a square around a point, or half a square
  /// near the maximum angle: a polynomial of degree 3; nullopt if not defined.
  std::optional<LocalMapping> Around(const Eigen::Vector2d& place) const;

  /// f in pixels, k1, k2; centre in pixels; camera_from_board: rotation vector,
  /// and translation in squares.
  using Parameters = std::array<double, 11>;

 private:
  LatticeLens(const Parameters& parameters, double max_angle_rad)
      : parameters_(parameters), max_angle_rad_(max_angle_rad) {}
  std::optional<std::vector<Correspondence>> Sample(
      const Eigen::Vector2d& place, double reach) const;

  Parameters parameters_;
  double max_angle_rad_;  // angle from the axis
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_LATTICE_LENS_H
