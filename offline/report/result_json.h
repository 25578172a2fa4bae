#ifndef RAYGRID_REPORT_RESULT_JSON_H
#define RAYGRID_REPORT_RESULT_JSON_H

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/rig_result.h"

namespace raygrid {

/// The pinhole that a blob's own table undistorts to.
struct ViewFigures {
  ImageSize size = {0, 0};
  Eigen::Vector2d focal_px = {0, 0};   ///< fx, fy
  Eigen::Vector2d center_px = {0, 0};  ///< cx, cy
};

/// The findings of packing.
struct PackingFigures {
  size_t blob_bytes = 0;  ///< 0: there is no blob
  double unproject_error_px = 0;
  std::optional<double> remap_error_px;
  std::optional<ViewFigures> view = {};
  std::vector<std::string> remarks = {};  ///< on what the blob lacks
};

/// A rectified pair of a rig's cameras, as its report shows it.
struct StereoFigures {
  std::string left, right;  ///< names of cameras; of a vertical pair the upper
  std::string instant;      ///< the image's name
  bool is_vertical = false;
  int num_disparities = 0;  ///< that were searched, in the pictures' pixels
  /// How far features of both cameras are off a common row, or column, in
  /// pixels of a view as large as the left image.
  double rms_px = 0, max_px = 0;
  int num_features = 0;
};

/// Features that were calibrated with and that the final camera projects
/// nowhere, so that they are in no figures of errors.
size_t NumWithoutError(const CalibrationResult& result);

/// result.json, by formats/json/result.schema.json. The memory figure and the
/// seconds differ from run to run; everything else is the same for the same
/// input.
///
/// A single camera's figures are the whole. A rig has sums and errors over all
/// cameras, held out with each board localised once for all cameras; how the
/// cameras stand to each other; then each camera's own figures, held out with
/// its images localised alone.
std::string FormatResultJson(
    const RigResult& result, uint64_t seed, int64_t peak_memory_bytes,
    const std::vector<std::optional<PackingFigures>>& packing = {},
    const std::optional<StereoFigures>& stereo = {});

/// The figures that result.json holds; what has files of its own, as the
/// camera, the features and their residuals, is empty.
struct ResultFigures {
  RigResult result;
  std::vector<std::optional<PackingFigures>> packing;  ///< by camera
  std::optional<StereoFigures> stereo;
  std::vector<std::string> rigid_target_summary;  ///< BodySentences()
};

/// Reads files of older versions, too. Throws InputError, also for newer ones.
ResultFigures ParseResultJson(const std::string& path, const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_RESULT_JSON_H
