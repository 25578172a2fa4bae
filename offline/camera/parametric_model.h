#ifndef RAYGRID_CAMERA_PARAMETRIC_MODEL_H
#define RAYGRID_CAMERA_PARAMETRIC_MODEL_H

#include <memory>
#include <string>
#include <vector>

#include "camera/camera_model.h"

namespace raygrid {

/// A model with few, global parameters, which is therefore defined for any
/// area.
class ParametricModel : public CameraModel {
 public:
  const ParametricModel* Parametric() const override { return this; }
  virtual const std::vector<std::string>& ParameterNames() const = 0;

  /// For each named parameter, the power of r of the image displacement it
  /// causes (3 for OpenCV's k1). Negative for tangential and tilt terms (-2 for
  /// p1); 0 for focal lengths, principal point and others.
  virtual std::vector<int> DistortionOrders() const {
    return std::vector<int>(ParameterNames().size(), 0);
  }

  /// Returns the model with these parameters over another area.
  virtual std::unique_ptr<ParametricModel> CloneWithArea(
      const Area& area) const = 0;

 protected:
  using CameraModel::CameraModel;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PARAMETRIC_MODEL_H
