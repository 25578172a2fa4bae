#ifndef RAYGRID_EXCHANGE_PYTHON_FORMAT_H
#define RAYGRID_EXCHANGE_PYTHON_FORMAT_H

#include <string>

#include "exchange/format.h"

namespace raygrid {

/// Cameras of OpenCV's keys and models as Python writes them without
/// FileStorage: lists of JSON and YAML, and arrays of numpy.savez().
Format PythonFormat();

/// Whether an archive of numpy has a camera matrix and coefficients.
bool IsCameraNpz(const std::string& bytes);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PYTHON_FORMAT_H
