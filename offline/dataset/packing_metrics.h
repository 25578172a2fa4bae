#ifndef RAYGRID_DATASET_PACKING_METRICS_H
#define RAYGRID_DATASET_PACKING_METRICS_H

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "camera/area.h"

namespace raygrid {

/// The pinhole view of a blob's default remap table.
struct ViewMetrics {
  ImageSize size = {0, 0};
  Eigen::Vector2d focal_px = {0, 0};   ///< fx, fy
  Eigen::Vector2d center_px = {0, 0};  ///< cx, cy
};

/// Metrics of packing.
struct PackingMetrics {
  size_t blob_bytes = 0;  ///< 0: no blob
  double unproject_error_px = 0;
  std::optional<double> remap_error_px;
  std::optional<ViewMetrics> view = {};
  std::vector<std::string> warnings = {};  ///< such as missing sections
};

}  // namespace raygrid

#endif  // RAYGRID_DATASET_PACKING_METRICS_H
