#ifndef RAYGRID_EVALUATION_ENOUGH_IMAGES_H
#define RAYGRID_EVALUATION_ENOUGH_IMAGES_H

namespace raygrid {

/// The fewest images that show how much a camera may differ from a lens of few
/// parameters, and so how well it is known.
constexpr int kEnoughImages = 10;

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_ENOUGH_IMAGES_H
