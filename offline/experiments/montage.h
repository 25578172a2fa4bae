#ifndef RAYGRID_EXPERIMENTS_MONTAGE_H
#define RAYGRID_EXPERIMENTS_MONTAGE_H

#include <string>
#include <vector>

#include "dataset/image_files.h"
#include "report/color_scale.h"

namespace raygrid {

struct MontageImage {
  std::string caption;
  Image image;
};

/// Draws pictures with captions, three per row, of equal width; the note is
/// below, with a legend beside it, if there is one.
Image ComposeMontage(const std::vector<MontageImage>& pictures,
                     const std::vector<std::string>& note, const Image* legend);

/// Draws a colour bar with labels at its ends.
Image DrawColorLegend(ColorScale scale, const std::string& low,
                      const std::string& high);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_MONTAGE_H
