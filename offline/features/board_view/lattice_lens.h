#ifndef RAYGRID_FEATURES_BOARD_VIEW_LATTICE_LENS_H
#define RAYGRID_FEATURES_BOARD_VIEW_LATTICE_LENS_H

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "dataset/dataset.h"
#include "features/board_view/local_mapping.h"

namespace raygrid {

/// The radial lens, and the pose of a flat board, that explain one lattice of
/// features best: a direction at the angle t from the axis is seen
/// f (t + k1 t^3 + k2 t^5) from the centre. Where there are no features, as on
/// large tags at a fisheye's rim, and behind them, it tells where the board
/// goes on; to a pixel or so, as real lenses are not quite radial.
class LatticeLens {
 public:
  /// Nothing for less than 20 features, or where half of them are seen more
  /// than a pixel from where any such lens would show them.
  static std::optional<LatticeLens> Fit(const std::vector<Feature>& features,
                                        const ImageSize& size);

  /// The pixel where a place on the lattice, in squares, is seen; nothing where
  /// its angle from the axis is a fifth larger than any feature's.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector2d& place) const;
  /// How the board appears within a square of a place, or half of one where the
  /// lens is not known farther: a polynomial of degree 3.
  std::optional<LocalMapping> Around(const Eigen::Vector2d& place) const;

  /// f in pixels, k1, k2; the centre in pixels; the pose: the rotation vector
  /// and the translation in squares, camera from board.
  using Parameters = std::array<double, 11>;

 private:
  LatticeLens(const Parameters& parameters, double max_angle_rad)
      : parameters_(parameters), max_angle_rad_(max_angle_rad) {}
  std::optional<std::vector<Correspondence>> Sample(
      const Eigen::Vector2d& place, double reach) const;

  Parameters parameters_;
  double max_angle_rad_;  // from the axis
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_LATTICE_LENS_H
