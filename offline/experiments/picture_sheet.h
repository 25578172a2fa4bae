#ifndef RAYGRID_EXPERIMENTS_PICTURE_SHEET_H
#define RAYGRID_EXPERIMENTS_PICTURE_SHEET_H

#include <string>
#include <vector>

#include "dataset/image_files.h"

namespace raygrid {

struct SheetPicture {
  std::string caption;
  Image image;
};

/// Pictures side by side with their captions, three in a row, all as wide; the
/// note stands below, and a legend beside it, if there is one.
Image PictureSheet(const std::vector<SheetPicture>& pictures,
                   const std::vector<std::string>& note, const Image* legend);

/// A bar of the magnitude pictures' colours, from 0 to full_scale_px.
Image MagnitudeLegend(double full_scale_px);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_PICTURE_SHEET_H
