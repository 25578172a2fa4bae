#ifndef RAYGRID_DATASET_RIG_FILE_H
#define RAYGRID_DATASET_RIG_FILE_H

#include <string>
#include <vector>

#include "camera/pose.h"

namespace raygrid {

/// A camera of a rig.
struct RigFileCamera {
  std::string name;
  std::string file;  ///< camera.yaml or blob, relative to the rig file
  Pose camera_from_rig;
};

/// Returns whether a camera name is valid: it consists of letters, digits, '-'
/// and '_', as it is used for folders and for links in the report.
bool IsRigCameraName(const std::string& name);

/// Reads rig.yaml, in the file's order. Throws InputError.
std::vector<RigFileCamera> ReadRigFile(const std::string& path);
/// Parses rig.yaml; path is used in errors.
std::vector<RigFileCamera> ParseRigFile(const std::string& path,
                                        const std::string& text);
std::string FormatRigFile(const std::vector<RigFileCamera>& cameras);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_RIG_FILE_H
