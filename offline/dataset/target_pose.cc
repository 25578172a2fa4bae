#include "dataset/target_pose.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "dataset/csv.h"

namespace raygrid {
namespace {

constexpr const char* kPoseAxes[] = {"rx", "ry", "rz", "tx", "ty", "tz"};

}  // namespace

double TargetPose::RotationStdDev() const {
  return std::sqrt(covariance.topLeftCorner<3, 3>().trace());
}

double TargetPose::TranslationStdDev() const {
  return std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
}

PoseCovariance RotateCovariance(const Pose& b_from_a,
                                const PoseCovariance& covariance) {
  PoseCovariance rotation = PoseCovariance::Zero();
  rotation.topLeftCorner<3, 3>() = rotation.bottomRightCorner<3, 3>() =
      b_from_a.rotation.toRotationMatrix();
  return rotation * covariance * rotation.transpose();
}

std::string FormatTargetPoses(const std::string& camera,
                              const std::vector<TargetPose>& poses) {
  std::string text = camera.empty() ? "" : "camera,";
  text += "image,board,qw,qx,qy,qz,tx,ty,tz,features,rms_px";
  for (int i = 0; i < 6; ++i)
    for (int k = i; k < 6; ++k)
      text += fmt::format(",cov_{}_{}", kPoseAxes[i], kPoseAxes[k]);
  text += "\n";
  const auto out = std::back_inserter(text);
  for (const TargetPose& target : poses) {
    Eigen::Quaterniond q = target.pose.camera_from_board.rotation;
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    const Eigen::Vector3d& t = target.pose.camera_from_board.translation;
    if (!camera.empty()) text += CsvField(camera) + ",";
    fmt::format_to(
        out, "{},{},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{},{:.4f}",
        CsvField(target.pose.image), target.pose.board, q.w(), q.x(), q.y(),
        q.z(), t.x(), t.y(), t.z(), target.num_features, target.rms_px);
    for (int i = 0; i < 6; ++i)
      for (int k = i; k < 6; ++k)
        fmt::format_to(out, ",{:.6g}", target.covariance(i, k));
    text += "\n";
  }
  return text;
}

}  // namespace raygrid
