#ifndef RAYGRID_EXCHANGE_PYTHON_FORMAT_H
#define RAYGRID_EXCHANGE_PYTHON_FORMAT_H

#include <string>

#include "exchange/format.h"

namespace raygrid {

/// Cameras with OpenCV's keys and models written by Python without FileStorage:
/// JSON and YAML lists, and archives of numpy.savez().
Format MakePythonFormat();

/// Returns whether an archive contains a camera matrix and coefficients.
bool IsCameraNpz(const std::string& bytes);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PYTHON_FORMAT_H
