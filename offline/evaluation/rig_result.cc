#include "evaluation/rig_result.h"

#include <fmt/format.h>

namespace raygrid {
namespace {

constexpr int kMinSharedViews = 5;
// Maximum ratio of joint to single-camera errors. With pure noise, a board pose
// from several cameras fits each of them nearly as well as a pose from that
// camera alone.
constexpr double kMaxTogetherRatio = 1.5;

ErrorMetrics ComputeRigMetrics(
    const std::vector<std::vector<FeatureResidual>>& by_camera) {
  std::vector<FeatureResidual> all;
  for (const auto& residuals : by_camera)
    all.insert(all.end(), residuals.begin(), residuals.end());
  return ComputeErrorMetrics(all);
}

int NumSharedViews(const RigResult& result, size_t camera) {
  int count = 0;
  for (const Baseline& baseline : result.baselines)
    if (baseline.first == camera || baseline.second == camera)
      count += baseline.num_shared_views;
  return count;
}

}  // namespace

std::vector<Baseline> ComputeBaselines(
    const std::vector<Pose>& camera_from_rig) {
  std::vector<Baseline> baselines;
  for (size_t a = 0; a < camera_from_rig.size(); ++a)
    for (size_t b = a + 1; b < camera_from_rig.size(); ++b) {
      const Pose b_from_a = camera_from_rig[b] * camera_from_rig[a].Inverse();
      Baseline baseline;
      baseline.first = a;
      baseline.second = b;
      baseline.distance_m = b_from_a.translation.norm();
      baseline.angle_rad =
          Eigen::Quaterniond::Identity().angularDistance(b_from_a.rotation);
      baselines.push_back(baseline);
    }
  return baselines;
}

ErrorMetrics ComputeTrainingMetrics(const RigResult& result) {
  std::vector<std::vector<FeatureResidual>> by_camera;
  for (const CalibrationResult& camera : result.cameras)
    by_camera.push_back(camera.training);
  return ComputeRigMetrics(by_camera);
}

std::optional<ErrorMetrics> ComputeHeldOutMetrics(const RigResult& result) {
  const ErrorMetrics metrics = ComputeRigMetrics(result.held_out);
  if (metrics.count == 0) return std::nullopt;
  return metrics;
}

Assessment AssessRig(const RigResult& result) {
  if (!result.IsRig()) return result.cameras.front().assessment;
  Assessment assessment = {"pass", {}};
  const auto worsen = [&assessment](const std::string& word) {
    if (word == "fail" || (word == "warn" && assessment.word == "pass"))
      assessment.word = word;
  };
  const auto warn = [&](const std::string& reason) {
    worsen("warn");
    assessment.reasons.push_back(reason);
  };
  std::vector<std::vector<FeatureResidual>> alone;
  for (size_t c = 0; c < result.cameras.size(); ++c) {
    const CalibrationResult& camera = result.cameras[c];
    if (camera.assessment.word == "fail" && assessment.word != "fail")
      assessment.failure =
          camera.camera.name + ": " + camera.assessment.failure;
    worsen(camera.assessment.word);
    for (const std::string& reason : camera.assessment.reasons)
      assessment.reasons.push_back(camera.camera.name + ": " + reason);
    const int num_shared = NumSharedViews(result, c);
    if (num_shared < kMinSharedViews)
      warn(fmt::format(
          "{}: only {} views in common with other cameras; capture at least {}",
          camera.camera.name, num_shared, kMinSharedViews));
    alone.push_back(camera.held_out);
  }
  for (const AmbiguousPair& pair : result.ambiguous_pairs)
    warn(fmt::format(
        "{} and {}: their relative pose is ambiguous by a rotation of the "
        "symmetric board, which their {} common views do not resolve; tilt the "
        "board in other directions, or use a board with one more row of "
        "squares",
        result.cameras[pair.first].camera.name,
        result.cameras[pair.second].camera.name, pair.num_shared_views));
  const auto together = ComputeHeldOutMetrics(result);
  const ErrorMetrics apart = ComputeRigMetrics(alone);
  if (together && apart.count > 0 &&
      together->median_px > kMaxTogetherRatio * apart.median_px)
    warn(fmt::format(
        "the held-out error of the rig is {:.1f} times that of single cameras; "
        "check that they are rigidly mounted and synchronized",
        together->median_px / apart.median_px));
  return assessment;
}

}  // namespace raygrid
