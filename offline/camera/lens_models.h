#ifndef RAYGRID_CAMERA_LENS_MODELS_H
#define RAYGRID_CAMERA_LENS_MODELS_H

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "camera/parametric_model.h"

namespace raygrid {

/// A model whose parameters are all named numbers: every parametric one but
/// central-radial, which has a spline.
struct LensModel {
  std::string name;                     ///< "opencv"
  std::vector<std::string> parameters;  ///< ParametricModel::ParameterNames()
  /// A lens of so many parameters.
  std::unique_ptr<ParametricModel> (*make)(const ImageSize& image_size,
                                           const Area& area,
                                           const Eigen::VectorXd& parameters);
  /// Parameters that a fit starts from, for lenses of f pixels a radian in the
  /// centre; the first bend as little as they can.
  std::vector<Eigen::VectorXd> (*starts)(double f, double cx, double cy);
};

/// opencv, opencv-14, thin-prism-fisheye, omni-radtan, double-sphere, eucm.
const std::vector<LensModel>& LensModels();

/// Null if there is none of this name.
const LensModel* FindLensModel(const std::string& name);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_LENS_MODELS_H
