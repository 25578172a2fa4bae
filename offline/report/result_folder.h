/// The output folder of calibrate: its files contain everything in the report.
#ifndef RAYGRID_REPORT_RESULT_FOLDER_H
#define RAYGRID_REPORT_RESULT_FOLDER_H

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "dataset/files.h"
#include "dataset/image_files.h"
#include "report/html_report.h"
#include "report/result_json.h"
#include "report/stereo_figures.h"
#include "report/thumbnails.h"

namespace raygrid {

/// Additional outputs of a camera.
struct CameraExtras {
  std::string blob = {};  ///< packed blob, or empty
  std::string view = {};  ///< view of its remap table as a camera file, or
                          ///< empty
  /// camera.yaml of known intrinsics, or empty
  std::string camera_yaml = {};
  std::optional<PackingMetrics> packing = {};
  std::optional<BeforeAfter> example = {};
  Thumbnails thumbnails = {};
};
struct ResultExtras {
  uint64_t seed = 0;
  int64_t peak_memory_bytes = 0;
  std::vector<CameraExtras> cameras;
  std::optional<StereoExample> stereo = {};  ///< only for rigs with images
};

/// Returns the path prefix of a camera's files in the result folder: "NAME/" in
/// a rig, empty for a single camera.
std::string CameraFolder(const RigResult& result, size_t camera);

/// Adds all files except the report.
void AddResultFiles(const RigResult& result, const ResultExtras& extras,
                    const std::string& folder, OutputFiles* files);

/// Lists the files that a result in a folder may consist of, including files of
/// a rig's cameras; they are removed when another result is written there.
std::set<std::string> ResultFiles(const std::string& folder);

/// Returns whether a folder contains the result of a completed calibration.
bool HasFinishedResult(const std::string& folder);

/// Reads a calibration's result and metrics from its folder. Throws InputError
/// for missing, malformed or incompatible files.
ResultMetrics ReadResultFolder(const std::string& folder);

/// Makes report.html from the other files of the folder; for a rig, also
/// NAME/report.html of each camera. Throws InputError for missing, malformed or
/// incompatible files.
void AddReports(const std::string& folder, OutputFiles* files);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_RESULT_FOLDER_H
