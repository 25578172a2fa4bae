#include "camera/camera_frame.h"

#include <vector>

#include "camera/model_fitting.h"
#include "camera/rotated_camera.h"

namespace raygrid {

CanonicalFrame ComputeCanonicalFrame(const CameraModel& camera,
                                     const std::string& lens) {
  constexpr double kMaxErrorRatio = 0.98;
  if (camera.Parametric())
    return {camera.Name(), Eigen::Quaterniond::Identity()};
  const std::vector<std::string> lenses =
      lens.empty() ? ListModelNames(ModelUse::kCompare)
                   : std::vector<std::string>{lens};
  CanonicalFrame frame;
  double min_error_px = INFINITY;
  for (const std::string& name : lenses) {
    const FittedModel fit =
        FitParametricModel(name, camera, camera.area(), {true});
    if (!(fit.rms_px < kMaxErrorRatio * min_error_px)) continue;
    min_error_px = fit.rms_px;
    frame = {name, fit.model_from_camera};
  }
  return frame;
}

std::unique_ptr<CameraModel> Rotated(
    const CameraModel& camera, const Eigen::Quaterniond& rotated_from_camera) {
  std::unique_ptr<CameraModel> turned =
      camera.FittedTo(RotatedCamera(camera, rotated_from_camera));
  turned->SetImageCircle(camera.image_circle());
  return turned;
}

std::optional<Eigen::Quaterniond> AlignToCanonicalFrame(
    std::shared_ptr<const CameraModel>* camera) {
  constexpr double kMinMisalignmentRad = 1 * M_PI / 180;
  const CanonicalFrame frame = ComputeCanonicalFrame(**camera);
  if (frame.AngleRad() <= kMinMisalignmentRad) return std::nullopt;
  if ((*camera)->IsCentral())
    *camera =
        std::make_shared<RotatedCamera>(**camera, frame.frame_from_camera);
  else
    *camera = Rotated(**camera, frame.frame_from_camera);
  return frame.frame_from_camera;
}

}  // namespace raygrid
