/// The folder that the generic model's authors call a state: a file for each
/// camera, and files of poses, features and points beside them.
#ifndef RAYGRID_EXCHANGE_PUZZLEPAINT_STATE_H
#define RAYGRID_EXCHANGE_PUZZLEPAINT_STATE_H

#include <optional>
#include <string>
#include <vector>

#include "exchange/format.h"

namespace raygrid {

/// The number in a name "intrinsics1.yaml"; none for other names.
std::optional<int> ParseCameraFileIndex(const std::string& path);

/// The path of a camera's file.
std::string MakeStateFilePath(const std::string& folder, int camera);

/// Files beside one of a camera, in the order of ReadRequest::beside: poses of
/// the cameras, poses of the rig, features, points. None beside a file of
/// another name.
std::vector<std::string> ListStateFiles(const std::string& path);

/// Fills the camera's pose in the rig, and those of boards, from the files
/// beside it. Throws InputError, naming the file.
void ReadCameraState(const ReadRequest& request, ReadLens* camera,
                     std::vector<std::string>* warnings);

/// The files beside those of cameras, whose order is that of their numbers.
/// path: of the first one. beside: texts of ListStateFiles(path).
std::vector<CompanionFile> WriteState(const std::string& path,
                                      const std::vector<WrittenLens>& cameras,
                                      const std::vector<std::string>& beside);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PUZZLEPAINT_STATE_H
