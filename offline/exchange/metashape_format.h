#ifndef RAYGRID_EXCHANGE_METASHAPE_FORMAT_H
#define RAYGRID_EXCHANGE_METASHAPE_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// The XML calibration of Agisoft Metashape.
Format MakeMetashapeFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_METASHAPE_FORMAT_H
