/// The folder that calibrate writes: everything that the report says is in its
/// files.
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
#include "report/stereo_pictures.h"
#include "report/thumbnails.h"

namespace raygrid {

/// The extras of a camera: what goes into the files beside its result.
struct CameraExtras {
  std::string blob = {};  ///< none if it is empty
  std::string view = {};  ///< its table's view, a camera file; or none
  std::optional<PackingFigures> packing = {};
  std::optional<BeforeAfter> example = {};
  Thumbnails thumbnails = {};
};
struct ResultExtras {
  uint64_t seed = 0;
  int64_t peak_memory_bytes = 0;
  std::vector<CameraExtras> cameras;
  std::optional<StereoExample> stereo = {};  ///< of a rig with images
};

/// The start of the paths of a camera's own files, from the result's folder:
/// "NAME/" in a rig, nothing for a single camera.
std::string CameraFolder(const RigResult& result, size_t camera);

/// All files but the report.
void AddResultFiles(const RigResult& result, const ResultExtras& extras,
                    const std::string& folder, OutputFiles* files);

/// The files that a result may have in a folder, those of the cameras among
/// them if it has a rig's: what goes when another result is written there.
std::set<std::string> ResultFiles(const std::string& folder);

/// Whether a folder holds the result of a calibration that came to its end.
bool HasFinishedResult(const std::string& folder);

/// A calibration's result and figures from the files of its folder. Throws
/// InputError where one is missing, malformed or of another version.
ResultFigures ReadResultFolder(const std::string& folder);

/// report.html from the other files of the folder; for a rig NAME/report.html
/// of each camera as well. Throws InputError where one is missing, malformed or
/// of another version.
void AddReports(const std::string& folder, OutputFiles* files);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_RESULT_FOLDER_H
