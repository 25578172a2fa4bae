#ifndef RAYGRID_DATASET_MOSAIC_H
#define RAYGRID_DATASET_MOSAIC_H

#include "dataset/image_files.h"

namespace raygrid {

/// Balances a raw colour mosaic (Bayer) that is stored as a grey image: scales
/// each of the four phases of 2 x 2 pixels so that grey surfaces, such as a
/// board, have equal values in all of them. Other images are unchanged. Returns
/// whether it was a mosaic.
bool BalanceMosaic(GreyLevels* image);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_MOSAIC_H
