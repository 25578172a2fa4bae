#ifndef RAYGRID_EXCHANGE_OPENCV_FORMAT_H
#define RAYGRID_EXCHANGE_OPENCV_FORMAT_H

#include "exchange/format.h"

namespace raygrid {

/// Cameras in OpenCV's FileStorage: YAML, XML or JSON by the file's ending, as
/// OpenCV's own calibration samples write them.
Format OpenCvFormat();

/// Cameras of the same keys and models as Python writes them without
/// FileStorage: lists of JSON and YAML, and arrays of numpy.savez().
Format PythonFormat();

/// Whether an archive of numpy has a camera matrix and coefficients.
bool IsNpzOfCamera(const std::string& bytes);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OPENCV_FORMAT_H
