#include "camera/model_registry.h"

#include "camera/double_sphere.h"
#include "camera/eucm.h"
#include "camera/omni_radtan.h"
#include "camera/opencv.h"
#include "camera/opencv_14.h"
#include "camera/thin_prism_fisheye.h"

namespace raygrid {
namespace {

using StartList = std::vector<Eigen::VectorXd>;

template <typename Model>
std::unique_ptr<ParametricModel> MakeModel(const ImageSize& image_size,
                                           const Area& area,
                                           const Eigen::VectorXd& parameters) {
  typename Model::ParameterArray array;
  std::copy(parameters.begin(), parameters.end(), array.begin());
  return std::make_unique<Model>(image_size, area, array);
}

template <size_t N>
StartList AsVectors(const std::vector<std::array<double, N>>& arrays) {
  StartList starts;
  for (const auto& array : arrays)
    starts.emplace_back(Eigen::Map<const Eigen::VectorXd>(array.data(), N));
  return starts;
}

template <typename Model>
ModelInfo MakeModelInfo(ModelUse use,
                        StartList (*starts)(double, double, double)) {
  const Model any({1, 1}, {}, {});
  return {any.Name(), use, any.ParameterNames(), &MakeModel<Model>, starts};
}

template <typename Formula>
ModelInfo MakeModelInfo(ModelUse use) {
  return MakeModelInfo<FormulaModel<Formula>>(
      use, [](double f, double cx, double cy) {
        return AsVectors(Formula::InitialValues(f, cx, cy));
      });
}

StartList OpenCvStarts(double f, double cx, double cy) {
  // The second initialization is an equidistant camera: Padé approximant of
  // atan(r) / r.
  return AsVectors<OpenCvModel::kCount>(
      {{f, f, cx, cy, 0, 0, 0, 0, 0, 0, 0, 0},
       {f, f, cx, cy, 1190 / 1155.0, 231 / 1155.0, 0, 1575 / 1155.0,
        525 / 1155.0, 25 / 1155.0, 0, 0}});
}

StartList FisheyeStarts(double f, double cx, double cy) {
  return AsVectors<ThinPrismFisheye::kCount>({{f, f, cx, cy}});
}

}  // namespace

const std::vector<ModelInfo>& GetModelRegistry() {
  static const std::vector<ModelInfo> models = {
      MakeModelInfo<OpenCvModel>(ModelUse::kAuto, OpenCvStarts),
      MakeModelInfo<OpenCv14Formula>(ModelUse::kFit),
      MakeModelInfo<ThinPrismFisheye>(ModelUse::kAuto, FisheyeStarts),
      MakeModelInfo<OmniRadtanFormula>(ModelUse::kFit),
      MakeModelInfo<DoubleSphereFormula>(ModelUse::kFit),
      MakeModelInfo<EucmFormula>(ModelUse::kFit),
      {models::kCentralRadial, ModelUse::kCompare, {}, nullptr, nullptr}};
  return models;
}

std::vector<std::string> ListModelNames(
    ModelUse use, const std::vector<std::string>& others) {
  std::vector<std::string> names;
  for (const ModelInfo& model : GetModelRegistry())
    if (model.use >= use) names.push_back(model.name);
  names.insert(names.end(), others.begin(), others.end());
  return names;
}

std::string OrList(const std::vector<std::string>& names) {
  std::string list = names.front();
  for (size_t k = 1; k < names.size(); ++k)
    list += (k + 1 < names.size() ? ", " : " or ") + names[k];
  return list;
}

const ModelInfo* FindModelInfo(const std::string& name) {
  for (const ModelInfo& model : GetModelRegistry())
    if (model.name == name) return &model;
  return nullptr;
}

}  // namespace raygrid
