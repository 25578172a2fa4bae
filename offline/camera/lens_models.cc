#include "camera/lens_models.h"

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

template <typename Formula>
LensModel ModelOfFormula() {
  return {Formula::kName, Formula::Names(), &MakeModel<FormulaLens<Formula>>,
          [](double f, double cx, double cy) {
            return AsVectors(Formula::Starts(f, cx, cy));
          }};
}

template <typename Model>
LensModel ModelOfClass(StartList (*starts)(double, double, double)) {
  const Model any({1, 1}, {}, {});
  return {any.Name(), any.ParameterNames(), &MakeModel<Model>, starts};
}

StartList OpenCvStarts(double f, double cx, double cy) {
  // Pade's approximation of atan(r) / r: an equidistant lens.
  return AsVectors<OpenCvModel::kCount>(
      {{f, f, cx, cy, 0, 0, 0, 0, 0, 0, 0, 0},
       {f, f, cx, cy, 1190 / 1155.0, 231 / 1155.0, 0, 1575 / 1155.0,
        525 / 1155.0, 25 / 1155.0, 0, 0}});
}

StartList FisheyeStarts(double f, double cx, double cy) {
  return AsVectors<ThinPrismFisheye::kCount>({{f, f, cx, cy}});
}

}  // namespace

const std::vector<LensModel>& LensModels() {
  static const std::vector<LensModel> models = {
      ModelOfClass<OpenCvModel>(OpenCvStarts),
      ModelOfFormula<OpenCv14Formula>(),
      ModelOfClass<ThinPrismFisheye>(FisheyeStarts),
      ModelOfFormula<OmniRadtanFormula>(),
      ModelOfFormula<DoubleSphereFormula>(),
      ModelOfFormula<EucmFormula>()};
  return models;
}

const LensModel* FindLensModel(const std::string& name) {
  for (const LensModel& model : LensModels())
    if (model.name == name) return &model;
  return nullptr;
}

}  // namespace raygrid
