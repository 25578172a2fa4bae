#ifndef RAYGRID_REPORT_RESULT_JSON_H
#define RAYGRID_REPORT_RESULT_JSON_H

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dataset/packing_metrics.h"
#include "evaluation/rig_result.h"

namespace raygrid {

/// A rectified stereo pair of a rig, for its report.
struct StereoMetrics {
  std::string left, right;  ///< camera names; vertical pair: upper, lower
  std::string frame;        ///< name of the frame
  bool is_vertical = false;
  int num_disparities = 0;  ///< search range, in the pictures' pixels
  /// Vertical disparity (horizontal for a vertical pair) of features in both
  /// cameras, in pixels of a view of the left image's size.
  double rms_px = 0, max_px = 0;
  int num_features = 0;
};

/// Returns the number of features used in the calibration that the final camera
/// cannot project, so that they are not included in error metrics.
size_t CountMissingErrors(const CalibrationResult& result);

/// Formats result.json; see formats/json/result.schema.json. Memory and seconds
/// vary; everything else is deterministic.
///
/// For a single camera, its metrics are at the top level. For a rig, the top
/// level contains totals and errors over all cameras (held-out errors with each
/// board localized once by all cameras) and the relative poses of cameras,
/// followed by each camera's own metrics (held-out errors with images localized
/// by that camera alone).
std::string FormatResultJson(
    const RigResult& result, uint64_t seed, int64_t peak_memory_bytes,
    const std::vector<std::optional<PackingMetrics>>& packing = {},
    const std::optional<StereoMetrics>& stereo = {});

/// Metrics in result.json; data in separate files, such as camera, features and
/// residuals, is empty.
struct ResultMetrics {
  RigResult result;
  std::vector<std::optional<PackingMetrics>> packing;  ///< by camera
  std::optional<StereoMetrics> stereo;
  std::vector<std::string> rigid_target_summary;  ///< DescribeRigidTargets()
};

/// Parses result.json, also of older versions. Throws InputError.
ResultMetrics ParseResultJson(const std::string& path, const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_RESULT_JSON_H
