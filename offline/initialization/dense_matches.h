#ifndef RAYGRID_INITIALIZATION_DENSE_MATCHES_H
#define RAYGRID_INITIALIZATION_DENSE_MATCHES_H

#include <vector>

#include "dataset/dataset.h"
#include "initialization/planar_pose_solver.h"

namespace raygrid {

/// The pixels that views are compared at: every step_px-th of every step_px-th
/// row, by number.
struct PixelLattice {
  int columns = 0, rows = 0, step_px = 1;

  int size() const { return columns * rows; }
  Eigen::Vector2d Pixel(int index) const {
    return {index % columns * step_px, index / columns * step_px};
  }
};

/// About 160 pixels along the longer side.
PixelLattice LatticeOf(const ImageSize& size);

/// A point of a board's plane, in metres, seen at a pixel of the lattice.
struct DenseMatch {
  int pixel = 0;
  Eigen::Vector2d point;
};

/// One board in one image.
struct DenseView {
  int image = 0;                    ///< index in the dataset
  int board = 0;                    ///< index in the pattern
  std::vector<DenseMatch> matches;  ///< by pixel
};

/// The board's points between a view's features (paper's supplement,
/// "Calibration initialization"): by the homography of each square of
/// neighbouring features; of two or three squares' width where features are
/// missing. Boards count as flat. Views without any such square are left out.
std::vector<DenseView> FormDenseViews(const Dataset& dataset,
                                      const Pattern& pattern,
                                      const PixelLattice& lattice);

/// The points that three views show at the pixels that all of them cover.
std::vector<BoardPointTriple> CommonMatches(const DenseView& first,
                                            const DenseView& second,
                                            const DenseView& third);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_DENSE_MATCHES_H
