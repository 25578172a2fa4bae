#ifndef RAYGRID_DATASET_RIG_FILE_H
#define RAYGRID_DATASET_RIG_FILE_H

#include <string>
#include <vector>

#include "camera/pose.h"
#include "dataset/target_pose.h"

namespace raygrid {

/// A camera of a rig.
struct RigFileCamera {
  std::string name;
  std::string file;  ///< camera.yaml or blob, relative to the rig file
  Pose camera_from_rig;
};

/// The covariance of the relative pose of two cameras, second_from_first: of
/// the update of UpdatedPose(), rotation vector (rad), then translation (m), in
/// the axes of the second camera.
struct RelativePoseCovariance {
  std::string first, second;  ///< camera names
  PoseCovariance covariance = PoseCovariance::Zero();

  /// Returns the standard deviation of the rotation (RMS angle, rad).
  double RotationStdDev() const;
  /// Returns the standard deviation of the distance between the cameras (m),
  /// for the translation of second_from_first.
  double DistanceStdDev(const Eigen::Vector3d& translation) const;
};

/// Returns whether a camera name is valid: it consists of letters, digits, '-'
/// and '_', as it is used for folders and for links in the report.
bool IsRigCameraName(const std::string& name);

/// Reads rig.yaml, in the file's order. Throws InputError.
std::vector<RigFileCamera> ReadRigFile(const std::string& path);
/// Parses rig.yaml; path is used in errors.
std::vector<RigFileCamera> ParseRigFile(const std::string& path,
                                        const std::string& text);
/// Parses the covariances of relative poses in rig.yaml; empty if there are
/// none. Throws InputError.
std::vector<RelativePoseCovariance> ParseRelativePoseCovariances(
    const std::string& path, const std::string& text);
/// Returns the covariance of two cameras in either order, or nullptr.
const RelativePoseCovariance* FindRelativePose(
    const std::vector<RelativePoseCovariance>& poses, const std::string& a,
    const std::string& b);
std::string FormatRigFile(
    const std::vector<RigFileCamera>& cameras,
    const std::vector<RelativePoseCovariance>& relative_poses = {});

}  // namespace raygrid

#endif  // RAYGRID_DATASET_RIG_FILE_H
