#include "calibration/frame_adjustment.h"

#include <cmath>
#include <utility>

#include "adjustment/smoothness_prior.h"
#include "calibration/divergence.h"
#include "camera/camera_frame.h"
#include "camera/central_generic.h"
#include "camera/fixed_camera.h"

namespace raygrid {
namespace {

// Rotations below 1/50 of the maximum acceptable frame rotation are negligible.
constexpr double kMinRotationRad = kMaxFrameRotationRad / 50;

// Rotates the prior of a grid: the mean is rotated and the precision is kept.
// The points of observation lines have the prior mean 0 in any frame.
CameraPrior MakeRotatedPrior(const CameraPrior& prior,
                             const CameraModel& camera,
                             const std::vector<Eigen::Vector2d>& observed_px,
                             const Eigen::Quaterniond& rotated_from_camera,
                             double residual_variance) {
  const std::unique_ptr<CameraModel> mean = camera.Clone();
  mean->SetParameters(prior.mean);
  const CentralGeneric base = MakeCentral(*Rotated(*mean, rotated_from_camera));
  CameraPrior rotated;
  if (camera.IsCentral()) {
    rotated =
        MakeSmoothnessPrior(base, observed_px, prior.base_lens, prior.spread);
  } else {
    constexpr double kArbitraryDistanceM = 1;
    rotated = MakeNonCentralPrior(base, observed_px, kArbitraryDistanceM,
                                  prior.base_lens);
    rotated.groups.back() = prior.groups.back();
  }
  for (size_t g = 0; g < rotated.groups.size(); ++g)
    rotated.groups[g].SetPrecision(prior.groups[g].weight, residual_variance);
  return rotated;
}

// Rotates a camera and its prior. The rotated surfaces are refitted, which
// leaves regions without observations arbitrary, such as corners behind a fold;
// the orientation constraint is therefore defined relative to the refitted
// state.
void RotateCamera(size_t camera, const Eigen::Quaterniond& rotated_from_camera,
                  AdjustmentResult* adjusted) {
  AdjustmentState& state = adjusted->state;
  CameraPrior& prior = adjusted->prior.cameras[camera];
  prior = MakeRotatedPrior(
      prior, *state.cameras[camera],
      ObservedPixels(adjusted->problem, static_cast<int>(camera)),
      rotated_from_camera, std::pow(adjusted->summary.noise_px, 2));
  state.cameras[camera] = Rotated(*state.cameras[camera], rotated_from_camera);
  prior.orientation_difference =
      prior.OrientationError(state.cameras[camera]->Parameters());
  state.camera_from_rig[camera] =
      Pose{rotated_from_camera, Eigen::Vector3d::Zero()} *
      state.camera_from_rig[camera];
}

// Rotates cameras to their reference frames; returns whether any camera was
// rotated.
bool RotateCameras(AdjustmentResult* adjusted) {
  bool have_rotated = false;
  for (size_t c = 0; c < adjusted->state.cameras.size(); ++c) {
    if (IsFixed(*adjusted->state.cameras[c])) continue;
    const CanonicalFrame frame =
        ComputeCanonicalFrame(*adjusted->state.cameras[c]);
    if (frame.AngleRad() < kMinRotationRad) continue;
    RotateCamera(c, frame.frame_from_camera, adjusted);
    have_rotated = true;
  }
  if (have_rotated) adjusted->state.MoveRigToFirstCamera();
  return have_rotated;
}

}  // namespace

void OptimizeInCameraFrames(const AdjustmentOptions& options,
                            AdjustmentResult* adjusted) {
  constexpr int kRounds = 3;
  AdjustmentOptions as_before = options;
  as_before.fix_points = options.fix_points || !HavePointsMoved(*adjusted);
  for (int round = 1; round <= kRounds; ++round) {
    const AdjustmentResult before = *adjusted;
    if (!RotateCameras(adjusted)) return;
    as_before.fix_cameras = options.fix_cameras || round == kRounds;
    const double noise_px = adjusted->summary.noise_px;
    adjusted->summary = RunBundleAdjustment(
        adjusted->problem.views, adjusted->prior, as_before, &adjusted->state);
    adjusted->summary.noise_px = noise_px;
    FinalizeCameras(adjusted);
    if (!HasDiverged(*adjusted, before)) continue;
    *adjusted = before;
    return;
  }
}

}  // namespace raygrid
