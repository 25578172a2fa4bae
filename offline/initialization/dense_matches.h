#ifndef RAYGRID_INITIALIZATION_DENSE_MATCHES_H
#define RAYGRID_INITIALIZATION_DENSE_MATCHES_H

#include <vector>

#include "dataset/dataset.h"
#include "initialization/planar_pose_solver.h"

namespace raygrid {

/// The lattice of pixels at which views are compared: every step_px-th pixel of
/// every step_px-th row.
struct PixelLattice {
  int columns = 0, rows = 0, step_px = 1;

  int size() const { return columns * rows; }
  Eigen::Vector2d Pixel(int index) const {
    return {index % columns * step_px, index / columns * step_px};
  }
};

/// Makes a lattice of about 160 pixels along the longer side.
PixelLattice MakePixelLattice(const ImageSize& size);

/// A point of a board's plane, in metres, at a lattice pixel.
struct DenseMatch {
  int pixel = 0;
  Eigen::Vector2d point;
};

/// The dense matches of one board in one image.
struct DenseView {
  int image = 0;                    ///< index in the dataset
  int board = 0;                    ///< index in the pattern
  std::vector<DenseMatch> matches;  ///< by pixel
};

/// Interpolates board points between features (paper's supplement, "Calibration
/// initialization") by the homography of each square of neighbouring features,
/// two or three spacings wide where features are missing. Boards are assumed to
/// be planar. Views without any such square are omitted.
std::vector<DenseView> MakeDenseViews(const Dataset& dataset,
                                      const Pattern& pattern,
                                      const PixelLattice& lattice);

/// Returns the matches of three views at the pixels that all of them cover.
std::vector<BoardPointTriple> FindCommonMatches(const DenseView& first,
                                                const DenseView& second,
                                                const DenseView& third);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_DENSE_MATCHES_H
