#ifndef RAYGRID_CAMERA_MODEL_REGISTRY_H
#define RAYGRID_CAMERA_MODEL_REGISTRY_H

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "camera/parametric_model.h"

namespace raygrid {

/// Uses of a parametric model; each includes the preceding uses.
enum class ModelUse {
  kFit,        ///< fits to other cameras, and files of other programs
  kCalibrate,  ///< calibrate --model
  kCompare,    ///< comparisons in reports and experiments, and camera frames
  kAuto        ///< calibrate --model auto
};

/// A parametric model without a spline. central-radial, which has one, has only
/// a name and a use.
struct ModelInfo {
  std::string name;  ///< "opencv"
  ModelUse use = ModelUse::kFit;
  std::vector<std::string> parameters;  ///< ParametricModel::ParameterNames()
  /// Creates a model with the given parameters.
  std::unique_ptr<ParametricModel> (*make)(
      const ImageSize& image_size, const Area& area,
      const Eigen::VectorXd& parameters) = nullptr;
  /// Initial parameters of fits, for a focal length of f pixels per radian in
  /// the centre; the first have minimal distortion.
  std::vector<Eigen::VectorXd> (*starts)(double f, double cx,
                                         double cy) = nullptr;
};

/// Returns all parametric models, including central-radial.
const std::vector<ModelInfo>& GetModelRegistry();

/// Returns the names of the models with this use, followed by `others`.
std::vector<std::string> ListModelNames(
    ModelUse use, const std::vector<std::string>& others = {});
/// Formats a list: "a, b or c".
std::string OrList(const std::vector<std::string>& names);

/// Returns null if there is no parametric model with this name.
const ModelInfo* FindModelInfo(const std::string& name);
inline bool IsParametricModel(const std::string& name) {
  return FindModelInfo(name) != nullptr;
}

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_MODEL_REGISTRY_H
