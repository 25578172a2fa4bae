/// The cameras of raygrid calibrate --intrinsics.
#ifndef RAYGRID_TOOLS_KNOWN_INTRINSICS_H
#define RAYGRID_TOOLS_KNOWN_INTRINSICS_H

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "dataset/camera_file.h"

namespace raygrid {

/// Known intrinsics of a camera, and the text of its camera.yaml, which is
/// copied to the result; empty for a file of another program.
struct KnownIntrinsics {
  std::shared_ptr<const CameraFile> file;
  std::string yaml;
};
using IntrinsicsByCamera = std::map<std::string, KnownIntrinsics>;

void AddIntrinsicsOption(CLI::App* command, std::vector<std::string>* texts);

/// Reads NAME=FILE for cameras of these names; a name is "" for a single
/// camera. Throws Error(kUsage) for unknown names, a single camera, blobs and
/// cameras without constant intrinsics; InputError.
IntrinsicsByCamera ReadKnownIntrinsics(const std::vector<std::string>& texts,
                                       const std::vector<std::string>& names);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_KNOWN_INTRINSICS_H
