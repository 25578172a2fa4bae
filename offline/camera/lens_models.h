#ifndef RAYGRID_CAMERA_LENS_MODELS_H
#define RAYGRID_CAMERA_LENS_MODELS_H

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "camera/parametric_model.h"

namespace raygrid {

/// What a parametric model is used for; each also for what precedes it.
enum class ModelUse {
  kFit,        ///< fits to other cameras, and files of other programs
  kCalibrate,  ///< calibrate --model
  kCompare,    ///< comparisons in reports and experiments, and camera frames
  kAuto        ///< calibrate --model auto
};

/// A parametric model whose parameters are all named numbers. central-radial,
/// which also has a spline, has a name and a use alone.
struct LensModel {
  std::string name;  ///< "opencv"
  ModelUse use = ModelUse::kFit;
  std::vector<std::string> parameters;  ///< ParametricModel::ParameterNames()
  /// A lens of so many parameters.
  std::unique_ptr<ParametricModel> (*make)(
      const ImageSize& image_size, const Area& area,
      const Eigen::VectorXd& parameters) = nullptr;
  /// Parameters that a fit starts from, for lenses of f pixels a radian in the
  /// centre; the first bend as little as they can.
  std::vector<Eigen::VectorXd> (*starts)(double f, double cx,
                                         double cy) = nullptr;
};

/// Every parametric model of few parameters.
const std::vector<LensModel>& LensModels();

/// The names of those that are used so, and other names behind them.
std::vector<std::string> LensNames(ModelUse use,
                                   const std::vector<std::string>& others = {});
/// "a, b or c".
std::string OrList(const std::vector<std::string>& names);

/// Null if there is none of this name.
const LensModel* FindLensModel(const std::string& name);
inline bool IsParametricModel(const std::string& name) {
  return FindLensModel(name) != nullptr;
}

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_LENS_MODELS_H
