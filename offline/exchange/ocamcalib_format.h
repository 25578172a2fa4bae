#ifndef RAYGRID_EXCHANGE_OCAMCALIB_FORMAT_H
#define RAYGRID_EXCHANGE_OCAMCALIB_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// calib_results.txt of OCamCalib (D. Scaramuzza's toolbox for omnidirectional
/// cameras), imported as a fitted grid.
Format MakeOcamCalibFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OCAMCALIB_FORMAT_H
