#ifndef RAYGRID_REPORT_STEREO_PLOTS_H
#define RAYGRID_REPORT_STEREO_PLOTS_H

#include <string>

#include "dataset/image_files.h"
#include "report/result_json.h"

namespace raygrid {

/// Two rectified images of equal size, 8-bit grey; images of a vertical pair
/// share columns.
struct RectifiedImages {
  Image first, second;
  Image first_mask;  ///< 0 where the first image has no source
  bool is_vertical = false;
};

/// Draws the images side by side (a vertical pair: one above the other), with
/// evenly spaced lines through both.
Image DrawRectifiedRows(const RectifiedImages& images);

/// Draws the first image's disparities in colours from 0 to num_disparities,
/// white where OpenCV's semi-global matching finds none. num_disparities must
/// be a multiple of 16.
Image DrawDisparityMap(const RectifiedImages& images, int num_disparities);

/// The stereo pictures of a rig's report, with their description.
struct StereoExample {
  StereoMetrics metrics;
  Image rows, disparity;
};
std::string MakeStereoSection(const StereoExample& example);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_STEREO_PLOTS_H
