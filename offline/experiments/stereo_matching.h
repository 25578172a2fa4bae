/// Depth from a rectified stereo pair.
#ifndef RAYGRID_EXPERIMENTS_STEREO_MATCHING_H
#define RAYGRID_EXPERIMENTS_STEREO_MATCHING_H

#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "experiments/experiment.h"

namespace raygrid {

/// Stereo matching by exhaustive search along rows with zero-mean normalized
/// cross-correlation, and parabolic interpolation of the best disparity.
struct Matching {
  static constexpr int kStepPx = 5, kHalfWindowPx = 10;

  double focal_px = 0;  ///< focal length of the rectified images
  int min_disparity = 0, max_disparity = 0;
};

double BaselineM(const StereoRig& cameras);

/// A point in the left camera's frame.
struct StereoPoint {
  Eigen::Vector2d left_pixel;
  Eigen::Vector3d point;
};

/// Points on a lattice of the rectified left image, row by row; nullopt without
/// a match.
struct StereoCloud {
  int columns = 0;
  std::vector<std::optional<StereoPoint>> points;
};

/// Matches two 32-bit floating-point grey images.
StereoCloud MatchStereo(const StereoRig& cameras, const Matching& matching,
                        const cv::Mat& left, const cv::Mat& right,
                        int num_threads);

/// Returns the point at a pixel of the left image, in the left camera's frame.
using Surface =
    std::function<std::optional<Eigen::Vector3d>(const Eigen::Vector2d&)>;

/// Returns a function that interpolates the point cloud of these images;
/// nullopt where the cloud is not smooth.
Surface MakeSurface(const StereoCloud& cloud, const StereoRig& cameras,
                    const Matching& matching);

/// Depth errors of a cloud relative to a surface, after alignment by a
/// similarity (Umeyama, 1991), over the cloud's lattice; NaN where undefined.
/// CompareToSurface() throws Error(kInsufficientData).
struct DepthErrorMap {
  int columns = 0, num_matched = 0;
  std::vector<double> error_mm;
  std::vector<double> depth_m;  ///< depth of the surface
  double similarity_scale = 1;
};
DepthErrorMap CompareToSurface(const StereoCloud& cloud,
                               const Surface& surface);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_STEREO_MATCHING_H
