#include <raygrid_host/rig.h>

#include <exception>
#include <filesystem>

#include "dataset/rig_file.h"

namespace raygrid {

template <typename Scalar>
std::vector<RigCamera<Scalar>> LoadRig(const std::string& path,
                                       std::string* error) {
  std::vector<RigFileCamera> files;
  try {
    files = ReadRigFile(path);
  } catch (const std::exception& exception) {
    if (error) *error = exception.what();
    return {};
  }
  const std::filesystem::path folder =
      std::filesystem::path(path).parent_path();
  std::vector<RigCamera<Scalar>> rig;
  for (const RigFileCamera& file : files) {
    auto camera = Camera<Scalar>::Load((folder / file.file).string(), error);
    if (!camera) return {};
    const Pose& pose = file.camera_from_rig;
    rig.push_back({file.name, *std::move(camera),
                   PoseTransform(Eigen::Translation3d(pose.translation) *
                                 pose.rotation)});
  }
  return rig;
}

template std::vector<RigCamera<double>> LoadRig<double>(const std::string&,
                                                        std::string*);
template std::vector<RigCamera<float>> LoadRig<float>(const std::string&,
                                                      std::string*);

}  // namespace raygrid
