#ifndef RAYGRID_DATASET_RECTIFIED_FILE_H
#define RAYGRID_DATASET_RECTIFIED_FILE_H

#include <Eigen/Core>
#include <array>
#include <string>

#include "camera/area.h"

namespace raygrid {

/// The contents of rectified.yaml: two views with common rows.
struct RectifiedFile {
  std::array<std::string, 2> names;  ///< left and right
  ImageSize size;                    ///< size of both views
  /// Projection matrices of points in the left view's axes; K is common.
  std::array<Eigen::Matrix<double, 3, 4>, 2> p;
};

/// Parses the file; path is used in errors. Throws InputError.
RectifiedFile ParseRectifiedFile(const std::string& path,
                                 const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_RECTIFIED_FILE_H
