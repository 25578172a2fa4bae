#ifndef RAYGRID_EXCHANGE_PHOTONVISION_FORMAT_H
#define RAYGRID_EXCHANGE_PHOTONVISION_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// The JSON of a calibration by PhotonVision: a camera, its corners and its
/// boards' poses.
Format PhotonVisionFormat();

/// Whether a text may be such a file: the lens's key is that of mrcal, too.
bool IsPhotonVision(const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PHOTONVISION_FORMAT_H
