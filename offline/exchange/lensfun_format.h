#ifndef RAYGRID_EXCHANGE_LENSFUN_FORMAT_H
#define RAYGRID_EXCHANGE_LENSFUN_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// Lenses of Lensfun's database, as documented there ("Declaring lenses",
/// "lfDistortionModel"): poly3, poly5 and ptlens on a rectilinear or fisheye
/// projection.
Format MakeLensfunFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_LENSFUN_FORMAT_H
