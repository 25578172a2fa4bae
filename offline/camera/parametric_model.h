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
  const ParametricModel* Parametric() const override { return this; }
  virtual const std::vector<std::string>& ParameterNames() const = 0;

  /// Powers of the radius that named parameters move an image by: 3 of OpenCV's
  /// k1. Negative for those that tilt the lens, -2 of p1; 0 for focal lengths,
  /// the centre, and what is none of these.
  virtual std::vector<int> DistortionOrders() const {
    return std::vector<int>(ParameterNames().size(), 0);
  }

  /// The model with these parameters over another area.
  virtual std::unique_ptr<ParametricModel> CloneWithArea(
      const Area& area) const = 0;

 protected:
  using CameraModel::CameraModel;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PARAMETRIC_MODEL_H
