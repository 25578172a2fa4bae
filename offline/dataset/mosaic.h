#ifndef RAYGRID_DATASET_MOSAIC_H
#define RAYGRID_DATASET_MOSAIC_H

#include "dataset/image_files.h"

namespace raygrid {

/// Makes a raw colour mosaic (Bayer), stored as a grey image, a grey image:
/// each of the four phases of 2 x 2 pixels is scaled so that what is grey in
/// the scene is as bright in all of them, as a board is. Other images stay as
/// they are. Whether it was a mosaic.
bool BalanceMosaic(GreyLevels* image);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_MOSAIC_H
