#ifndef RAYGRID_FLEET_BATCH_PLAN_H
#define RAYGRID_FLEET_BATCH_PLAN_H

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace raygrid {

/// A camera or a rig to be calibrated.
struct BatchUnit {
  std::string serial;   ///< letters, digits and . _ - +; also the folder's name
  std::string pattern;  ///< as in the plan: a file, or the name of a board
  /// Either a folder of images, or features, or one folder per camera, or per
  /// value of an operating condition.
  std::string images, features;
  std::map<std::string, std::string> cameras, cameras_at;
  /// Options of raygrid calibrate, in an order that depends only on the plan.
  std::vector<std::string> options;
  /// Files read by options of raygrid calibrate, by option name.
  std::map<std::string, std::string> option_files;
  std::string lens_batch;  ///< the batch of lenses that it has one of, or ""
  /// The golden unit of which this is a repeat calibration, or "".
  std::string repeats;
  std::string person, station;  ///< who calibrated it, and where, or ""
};

/// Lower and upper limits of metrics; both may be infinite.
using MetricLimits = std::map<std::string, std::pair<double, double>>;

/// The plan.yaml of raygrid batch; see offline/fleet/README.md.
struct BatchPlan {
  std::vector<BatchUnit> units;  ///< sorted by serial (bytewise)
  MetricLimits limits;           ///< keys are ListMetricNames()
};

/// The metrics of a unit that a plan can limit.
const std::vector<std::string>& ListMetricNames();

/// Throws InputError naming the path and the fault: not a plan, an unknown key,
/// a serial that is not a valid folder name or is repeated.
BatchPlan ParseBatchPlan(const std::string& path, const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_BATCH_PLAN_H
