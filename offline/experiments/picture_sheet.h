#ifndef RAYGRID_EXPERIMENTS_PICTURE_SHEET_H
#define RAYGRID_EXPERIMENTS_PICTURE_SHEET_H

#include <string>
#include <vector>

#include "dataset/image_files.h"
#include "report/color_scale.h"

namespace raygrid {

struct SheetPicture {
  std::string caption;
  Image image;
};

/// Pictures side by side with their captions, three in a row, all as wide; the
/// note stands below, and a legend beside it, if there is one.
Image PictureSheet(const std::vector<SheetPicture>& pictures,
                   const std::vector<std::string>& note, const Image* legend);

/// A bar of a scale's colours, with what stands at its ends.
Image ColorLegend(ColorScale scale, const std::string& low,
                  const std::string& high);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_PICTURE_SHEET_H
