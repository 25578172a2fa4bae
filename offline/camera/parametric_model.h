#ifndef RAYGRID_CAMERA_PARAMETRIC_MODEL_H
#define RAYGRID_CAMERA_PARAMETRIC_MODEL_H

#include <memory>
#include <string>
#include <vector>

#include "camera/camera_model.h"

namespace raygrid {

/// A lens with a few parameters, each of which acts everywhere, so that it may
/// be asked for any area.
class ParametricModel : public CameraModel {
 public:
  virtual const std::vector<std::string>& ParameterNames() const = 0;

  /// Powers of the radius that named parameters which bend the lens move an
  /// image by: 3 of OpenCV's k1. 0 of all others, as of those that tilt it.
  virtual std::vector<int> RadialOrders() const {
    return std::vector<int>(ParameterNames().size(), 0);
  }

  /// The model with these parameters over another area.
  virtual std::unique_ptr<ParametricModel> OverArea(const Area& area) const = 0;

 protected:
  using CameraModel::CameraModel;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PARAMETRIC_MODEL_H
