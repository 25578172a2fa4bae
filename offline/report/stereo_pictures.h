#ifndef RAYGRID_REPORT_STEREO_PICTURES_H
#define RAYGRID_REPORT_STEREO_PICTURES_H

#include <string>

#include "dataset/image_files.h"
#include "report/result_json.h"

namespace raygrid {

/// Two rectified images of one size, in shades of grey of 8 bits; those of a
/// vertical pair have common columns.
struct RectifiedImages {
  Image first, second;
  Image first_shown;  ///< 0 where the first image has no source
  bool is_vertical = false;
};

/// The images side by side, or of a vertical pair on top of each other, with
/// every so many rows drawn through both.
Image RowsPicture(const RectifiedImages& images);

/// The first image's disparities in colours from 0 to num_disparities, white
/// where OpenCV's semi-global matching finds none. num_disparities is a
/// multiple of 16.
Image DisparityPicture(const RectifiedImages& images, int num_disparities);

/// The pictures of a rig's report, and what they show.
struct StereoExample {
  StereoFigures figures;
  Image rows, disparity;
};
std::string StereoSection(const StereoExample& example);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_STEREO_PICTURES_H
