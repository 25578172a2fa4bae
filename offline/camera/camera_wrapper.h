#ifndef RAYGRID_CAMERA_CAMERA_WRAPPER_H
#define RAYGRID_CAMERA_CAMERA_WRAPPER_H

#include <memory>
#include <string>

#include "camera/camera_model.h"

namespace raygrid {

/// Base of cameras that transform another camera's observation lines or pixels,
/// for measurements and fits. A wrapper has no parameters.
class CameraWrapper : public CameraModel {
 public:
  std::string Name() const override { return camera_->Name(); }
  bool IsCentral() const override { return camera_->IsCentral(); }
  Eigen::VectorXd Parameters() const override { return {}; }
  void SetParameters(const Eigen::VectorXd&) override {}

 protected:
  CameraWrapper(const CameraModel& camera, const ImageSize& image_size,
                const Area& area)
      : CameraModel(image_size, area), camera_(camera.Clone()) {
    SetImageCircle(camera.image_circle());
  }

  const CameraModel& camera() const { return *camera_; }

  /// Removes the wrapped camera's parameters from its linearized projection.
  static void ForgetParameters(LinearizedProjection* projection) {
    projection->num_nodes = projection->num_per_node = 0;
    projection->num_global = projection->first_global = 0;
  }

 private:
  std::unique_ptr<CameraModel> camera_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_WRAPPER_H
