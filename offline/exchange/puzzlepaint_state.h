/// A state folder of the generic model's authors: a file per camera, and
/// companion files of poses, features and points.
#ifndef RAYGRID_EXCHANGE_PUZZLEPAINT_STATE_H
#define RAYGRID_EXCHANGE_PUZZLEPAINT_STATE_H

#include <optional>
#include <string>
#include <vector>

#include "exchange/format.h"

namespace raygrid {

/// Returns the index in "intrinsics1.yaml"; nullopt for other names.
std::optional<int> ParseCameraFileIndex(const std::string& path);

/// Returns the path of a camera's file.
std::string MakeStateFilePath(const std::string& folder, int camera);

/// Lists the companion files of a camera file in the order of
/// ReadRequest::beside: camera poses, rig poses, features, points. Empty if the
/// file name is not intrinsics<N>.yaml.
std::vector<std::string> ListStateFiles(const std::string& path);

/// Reads the camera's pose in the rig, and board poses, from the companion
/// files. Throws InputError with the file's name.
void ReadCameraState(const ReadRequest& request, InputCamera* camera,
                     std::vector<std::string>* warnings);

/// Makes the companion files of cameras, which are ordered by index. path: file
/// of the first camera; beside: texts of ListStateFiles(path).
std::vector<CompanionFile> WriteState(const std::string& path,
                                      const std::vector<OutputCamera>& cameras,
                                      const std::vector<std::string>& beside);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PUZZLEPAINT_STATE_H
