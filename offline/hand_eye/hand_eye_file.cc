#include "hand_eye/hand_eye_file.h"

#include <fmt/format.h>

#include <cmath>

#include "dataset/csv.h"
#include "dataset/pose_node.h"

namespace raygrid {
namespace {

std::string FormatCovariance(const PoseCovariance& covariance,
                             const std::string& indentation) {
  std::string text = indentation + "covariance:\n";
  for (int i = 0; i < 6; ++i) {
    text += indentation + "  - [";
    for (int k = 0; k < 6; ++k)
      text += fmt::format("{}{:.9e}", k > 0 ? ", " : "",
                          covariance(std::min(i, k), std::max(i, k)));
    text += "]\n";
  }
  return text;
}

std::string FormatTransform(const NamedTransform& transform) {
  return transform.name + ":\n" + FormatPose(transform.pose, "  ") +
         fmt::format("  rotation_sd_rad: {:.6g}\n  translation_sd_m: {:.6g}\n",
                     transform.RotationStdDev(),
                     transform.TranslationStdDev()) +
         FormatCovariance(transform.covariance, "  ");
}

std::string FormatErrorFields(const HandEyeError& error) {
  return fmt::format(",{:.9f},{:.9f},{:.4f}", error.rotation_rad,
                     error.translation_m, error.rms_px);
}

}  // namespace

double NamedTransform::RotationStdDev() const {
  return std::sqrt(covariance.topLeftCorner<3, 3>().trace());
}

double NamedTransform::TranslationStdDev() const {
  return std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
}

std::vector<NamedTransform> ListTransforms(const HandEyeFit& fit,
                                           Mounting mounting) {
  const HandEyeNames names = GetFrameNames(mounting);
  const Pose& camera = fit.hand_eye.camera_from_mount;
  const PoseCovariance covariance = fit.covariance.topLeftCorner<6, 6>();
  return {{names.camera_from_mount, camera, covariance},
          {names.mount_from_camera, camera.Inverse(),
           InverseCovariance(camera, covariance)},
          {names.anchor_from_target, fit.hand_eye.anchor_from_target,
           fit.covariance.bottomRightCorner<6, 6>()}};
}

std::string FormatHandEye(const std::string& camera, Mounting mounting,
                          const HandEyeResult& result) {
  std::string text = fmt::format(
      "mounting: {}\n",
      mounting == Mounting::kEyeInHand ? "eye-in-hand" : "eye-to-hand");
  if (!camera.empty()) text += fmt::format("camera: \"{}\"\n", camera);
  for (const NamedTransform& transform : ListTransforms(result.fit, mounting))
    text += FormatTransform(transform);
  text +=
      fmt::format("robot_sigma_rad: {:.6g}\nrobot_sigma_m: {:.6g}\nposes: {}\n",
                  result.fit.noise.rotation_rad, result.fit.noise.translation_m,
                  result.NumUsed());
  // The mandatory key is written last: truncated files are invalid.
  return text + "raygrid_hand_eye: 1\n";
}

std::string FormatHandEyeResiduals(
    const std::vector<HandEyeObservation>& observations,
    const HandEyeResult& result) {
  std::string text =
      "image,used,rotation_rad,translation_m,rms_px,held_out_rotation_rad,"
      "held_out_translation_m,held_out_rms_px,reason\n";
  for (size_t i = 0; i < observations.size(); ++i) {
    const HandEyePoseResult& pose = result.poses[i];
    text += CsvField(observations[i].image) + (pose.is_used ? ",1" : ",0") +
            FormatErrorFields(pose.residual) +
            (pose.held_out ? FormatErrorFields(*pose.held_out) : ",,,") + "," +
            CsvField(pose.reason) + "\n";
  }
  return text;
}

}  // namespace raygrid
