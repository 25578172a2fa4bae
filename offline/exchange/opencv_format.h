#ifndef RAYGRID_EXCHANGE_OPENCV_FORMAT_H
#define RAYGRID_EXCHANGE_OPENCV_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// Cameras in OpenCV's FileStorage: YAML, XML or JSON by extension, as written
/// by OpenCV's calibration samples.
Format OpenCvFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OPENCV_FORMAT_H
