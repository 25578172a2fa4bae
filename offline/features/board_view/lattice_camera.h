#ifndef RAYGRID_FEATURES_BOARD_VIEW_LATTICE_CAMERA_H
#define RAYGRID_FEATURES_BOARD_VIEW_LATTICE_CAMERA_H

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "dataset/dataset.h"
#include "features/board_view/local_mapping.h"

namespace raygrid {

/// A radial lens model and the pose of a planar board, fitted to the features
/// of one lattice: a ray at the angle t from the optical axis is projected to
/// the distance f (t + k1 t^3 + k2 t^5) from the distortion centre. Predicts
/// missing features within and outside the lattice, e.g. around large tags near
/// the edge of a fisheye image, to about a pixel, as real lenses are not
/// exactly radially symmetric.
class LatticeCamera {
 public:
  /// Returns nullopt for fewer than 20 features, or if the median residual
  /// exceeds a pixel.
  static std::optional<LatticeCamera> Fit(const std::vector<Feature>& features,
                                          const ImageSize& size);

  /// Projects a lattice position, in squares; nullopt if its angle from the
  /// optical axis exceeds the maximum angle of the features by more than 20 %.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector2d& place) const;
  /// Returns the local mapping around a position, a polynomial of degree 3
  /// fitted within a radius of 1 square (0.5 near the maximum angle); nullopt
  /// if the position is outside the valid range.
  std::optional<LocalMapping> Around(const Eigen::Vector2d& place) const;

  /// f in pixels, k1, k2; distortion centre in pixels; camera_from_board:
  /// rotation vector, translation in squares.
  using Parameters = std::array<double, 11>;

 private:
  LatticeCamera(const Parameters& parameters, double max_angle_rad)
      : parameters_(parameters), max_angle_rad_(max_angle_rad) {}
  std::optional<std::vector<Correspondence>> Sample(
      const Eigen::Vector2d& place, double reach) const;

  Parameters parameters_;
  double max_angle_rad_;  // from the optical axis
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_LATTICE_CAMERA_H
