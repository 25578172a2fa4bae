#ifndef RAYGRID_EXCHANGE_PHOTONVISION_FORMAT_H
#define RAYGRID_EXCHANGE_PHOTONVISION_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// PhotonVision's JSON calibration: a camera, its corners and board poses.
Format MakePhotonVisionFormat();

/// Returns whether a text may be such a file: mrcal has the same model key.
bool IsPhotonVision(const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PHOTONVISION_FORMAT_H
