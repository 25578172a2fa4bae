#ifndef RAYGRID_FLEET_BATCH_PLAN_H
#define RAYGRID_FLEET_BATCH_PLAN_H

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace raygrid {

/// A camera, or a rig, that is to be calibrated by itself.
struct BatchUnit {
  std::string serial;   ///< letters, digits and . _ - +; also its folder's name
  std::string pattern;  ///< as in the plan: a file, or a board in a word
  /// Either a folder of images, or features, or the folder of each camera, or
  /// of each value of a condition.
  std::string images, features;
  std::map<std::string, std::string> cameras, cameras_at;
  /// Options of raygrid calibrate, in one order for the same plan.
  std::vector<std::string> options;
  /// Files that options of raygrid calibrate read, by the options' names.
  std::map<std::string, std::string> option_files;
  std::string lens_batch;  ///< the batch of lenses that it has one of, or ""
  /// The golden unit that this is another calibration of, or "".
  std::string repeats;
  std::string person, station;  ///< who calibrated it, and where, or ""
};

/// The least and the most that a figure may be; both may be infinite.
using FigureLimits = std::map<std::string, std::pair<double, double>>;

/// plan.yaml of raygrid batch: offline/fleet/README.md.
struct BatchPlan {
  std::vector<BatchUnit> units;  ///< in the order of their serials' bytes
  FigureLimits limits;           ///< of names in FigureNames()
};

/// The figures of a unit that a plan may limit.
const std::vector<std::string>& FigureNames();

/// Throws InputError that names the path and what is wrong: no plan, a key that
/// is not known, a serial that is no name of a folder or stands twice.
BatchPlan ParseBatchPlan(const std::string& path, const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_BATCH_PLAN_H
