#ifndef RAYGRID_FLEET_BATCH_PLAN_H
#define RAYGRID_FLEET_BATCH_PLAN_H

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace raygrid {

/// A camera or a rig to be calibrated.
struct BatchUnit {
  std::string serial;   ///< letters, digits and . _ - +; also folder name
  std::string pattern;  ///< as in the plan: a file, or the name of a board
  /// Either a folder of images, or features, or one folder per camera, or per
  /// operating point.
  std::string images, features;
  std::map<std::string, std::string> cameras, cameras_at;
  /// Options of raygrid calibrate, in an order that depends only on the plan.
  std::vector<std::string> options;
  /// Files read by options of raygrid calibrate, by option name.
  std::map<std::string, std::string> option_files;
  std::string lens_batch;  ///< production batch of the lens, or ""
  /// Serial of the golden unit for which this is a repeated calibration, or "".
  std::string repeats;
  std::string person, station;  ///< operator and station, or ""
};

/// Lower and upper limits of metrics; both may be infinite.
using MetricLimits = std::map<std::string, std::pair<double, double>>;

/// The plan.yaml of raygrid batch; see offline/fleet/README.md.
struct BatchPlan {
  std::vector<BatchUnit> units;  ///< sorted by serial (bytewise)
  MetricLimits limits;           ///< keys from ListMetricNames()
};

/// Returns the names of metrics that a plan can limit.
const std::vector<std::string>& ListMetricNames();

/// Parses a plan. Throws InputError, with the path, for a malformed plan, an
/// unknown key, and a serial that is not unique or not a valid folder name.
BatchPlan ParseBatchPlan(const std::string& path, const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_BATCH_PLAN_H
