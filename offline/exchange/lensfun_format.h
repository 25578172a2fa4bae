#ifndef RAYGRID_EXCHANGE_LENSFUN_FORMAT_H
#define RAYGRID_EXCHANGE_LENSFUN_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// Lenses of Lensfun's database, as its documentation has them ("Declaring
/// lenses", "lfDistortionModel"): poly3, poly5 and ptlens on a rectilinear or
/// fisheye projection.
Format LensfunFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_LENSFUN_FORMAT_H
