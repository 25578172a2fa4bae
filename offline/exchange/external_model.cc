#include "exchange/external_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "camera/model_registry.h"
#include "camera/thin_prism_fisheye.h"
#include "camera/view_camera.h"
#include "dataset/error.h"
#include "dataset/image_header.h"

namespace raygrid {
namespace {

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

Eigen::Index IndexOf(const ModelInfo& model, const std::string& parameter) {
  const std::string& name = parameter == "f" ? "fx" : parameter;
  return std::find(model.parameters.begin(), model.parameters.end(), name) -
         model.parameters.begin();
}

constexpr double kLargestNumber = 1e12;

void RequireNumbers(const ExternalModel& external_model,
                    const std::vector<double>& values) {
  for (size_t k = 0; k < values.size(); ++k)
    if (!(std::abs(values[k]) <= kLargestNumber))
      throw InputError(fmt::format("{}: not a number, or larger than {:g}",
                                   external_model.parameters[k],
                                   kLargestNumber));
}

void RequireSize(const ImageSize& size) {
  if (size.width < 1 || size.height < 1)
    throw InputError("the image size must be two positive numbers");
  if (std::max(size.width, size.height) > kMaxHugeSidePx)
    throw InputError(
        fmt::format("image size: at most {} pixels per side are supported",
                    kMaxHugeSidePx));
}

void RequireFocalLengths(const Eigen::Vector2d& focal_px) {
  if (!(focal_px.minCoeff() > 0))
    throw InputError("focal lengths must be positive");
}

std::unique_ptr<ParametricModel> MakeParametricModel(
    const ConvertedCamera& lens) {
  const ExternalModel& external_model = *lens.external_model;
  const ModelInfo& model = *FindModelInfo(external_model.model);
  if (lens.values.size() != external_model.parameters.size())
    throw InputError(fmt::format("{0}: expected {2} numbers, found {1}",
                                 external_model.name, lens.values.size(),
                                 external_model.parameters.size()));
  RequireNumbers(external_model, lens.values);
  Eigen::VectorXd parameters = Eigen::VectorXd::Zero(model.parameters.size());
  for (size_t k = 0; k < lens.values.size(); ++k) {
    parameters[IndexOf(model, external_model.parameters[k])] = lens.values[k];
    if (external_model.parameters[k] == "f")
      parameters[IndexOf(model, "fy")] = lens.values[k];
  }
  RequireFocalLengths(parameters.head<2>());
  parameters.segment<2>(2) =
      FromProgram(external_model.origin, lens.size, parameters.segment<2>(2));
  return model.make(lens.size, WholeImage(lens.size), parameters);
}

std::unique_ptr<ParametricModel> MakeSpline(const ConvertedCamera& lens) {
  const Eigen::VectorXd parameters = lens.spline->Parameters();
  if (!(parameters.cwiseAbs().maxCoeff() <= kLargestNumber))
    throw InputError(
        fmt::format("{}: a parameter is not a number, or larger than {:g}",
                    lens.external_model->name, kLargestNumber));
  RequireFocalLengths(parameters.tail<4>().head<2>());
  return lens.spline->CloneWithArea(WholeImage(lens.size));
}

std::unique_ptr<CameraModel> MakeGrid(const ConvertedCamera& lens) {
  if (!(lens.grid->Parameters().cwiseAbs().maxCoeff() <= kLargestNumber))
    throw InputError(
        fmt::format("{}: a parameter is not a number, or larger than {:g}",
                    lens.external_model->name, kLargestNumber));
  return lens.grid->Clone();
}

// Returns the parametric model that the camera is an instance of. An
// equidistant view is a fisheye model without distortion.
std::unique_ptr<CameraModel> ConvertToParametric(const CameraModel& camera) {
  const auto* view = dynamic_cast<const ViewCamera*>(&camera);
  if (!view || view->projection() != ViewProjection::kEquidistant)
    return camera.Clone();
  ThinPrismFisheye::ParameterArray parameters = {};
  Eigen::Map<Eigen::Vector4d>(parameters.data()) = view->Parameters();
  return std::make_unique<ThinPrismFisheye>(camera.image_size(), camera.area(),
                                            parameters);
}

// Converts a pinhole model to the one with thin-prism and tilt coefficients,
// which are set to 0.
std::unique_ptr<CameraModel> ConvertToThinPrism(const CameraModel& pinhole) {
  const ModelInfo& model = *FindModelInfo(models::kOpenCv14);
  Eigen::VectorXd parameters = Eigen::VectorXd::Zero(model.parameters.size());
  const std::vector<std::string>& names =
      FindModelInfo(models::kOpenCv)->parameters;
  for (size_t k = 0; k < names.size(); ++k)
    parameters[IndexOf(model, names[k])] =
        pinhole.Parameters()[static_cast<Eigen::Index>(k)];
  return model.make(pinhole.image_size(), pinhole.area(), parameters);
}

}  // namespace

bool ExternalModel::Has(const std::string& parameter) const {
  return Contains(parameters, parameter);
}

std::vector<std::string> ExternalModel::Missing() const {
  std::vector<std::string> missing;
  if (IsSpline() || IsGrid()) return missing;
  for (const std::string& parameter : FindModelInfo(model)->parameters)
    if (!Has(parameter) &&
        !(Has("f") && (parameter == "fx" || parameter == "fy")))
      missing.push_back(parameter);
  return missing;
}

ExternalModel MakeExternalModel(const std::string& name,
                                const std::string& model,
                                const std::vector<std::string>& coefficients) {
  ExternalModel external_model = {name, model, {"fx", "fy", "cx", "cy"}};
  external_model.parameters.insert(external_model.parameters.end(),
                                   coefficients.begin(), coefficients.end());
  return external_model;
}

double ConvertedCamera::Value(const std::string& parameter) const {
  for (size_t k = 0; k < external_model->parameters.size(); ++k)
    if (external_model->parameters[k] == parameter) return values.at(k);
  throw std::out_of_range(parameter);
}

std::vector<double> ConvertedCamera::ValuesFrom(size_t first) const {
  return {values.begin() + static_cast<std::ptrdiff_t>(first), values.end()};
}

// Samples the centres of equal tiles of the area: samples on its edges would
// overweight edge effects such as folds.
double ComputeUndefinedFraction(const CameraModel& lens) {
  constexpr int kSamplesAcross = 64;
  const Area area = lens.area();
  int num_unconverted = 0;
  for (int j = 0; j < kSamplesAcross; ++j)
    for (int i = 0; i < kSamplesAcross; ++i)
      if (!lens.Unproject(
              {area.x0 + area.width() * (i + 0.5) / kSamplesAcross,
               area.y0 + area.height() * (j + 0.5) / kSamplesAcross}))
        ++num_unconverted;
  return static_cast<double>(num_unconverted) /
         (kSamplesAcross * kSamplesAcross);
}

std::unique_ptr<CameraModel> MakeCameraModel(const ConvertedCamera& lens) {
  const ExternalModel& external_model = *lens.external_model;
  RequireSize(lens.size);
  std::unique_ptr<CameraModel> made;
  if (external_model.IsGrid())
    made = MakeGrid(lens);
  else if (external_model.IsSpline())
    made = MakeSpline(lens);
  else
    made = MakeParametricModel(lens);
  if (ComputeUndefinedFraction(*made) == 1)
    throw InputError(
        fmt::format("{}: no pixel of the {} x {} image has a valid ray; check "
                    "model, parameters and image size",
                    external_model.name, lens.size.width, lens.size.height));
  return made;
}

std::optional<ConvertedCamera> ConvertToExternalModel(
    const ExternalModel& external_model, const CameraModel& camera) {
  if (external_model.IsGrid()) return std::nullopt;
  std::unique_ptr<CameraModel> lens = ConvertToParametric(camera);
  if (lens->Name() == models::kOpenCv &&
      external_model.model == models::kOpenCv14)
    lens = ConvertToThinPrism(*lens);
  if (lens->Name() != external_model.model) return std::nullopt;
  if (external_model.IsSpline())
    return ConvertedCamera{
        &external_model,
        lens->image_size(),
        {},
        std::make_shared<SplinedStereographic>(
            dynamic_cast<const SplinedStereographic&>(*lens))};
  const ModelInfo& model = *FindModelInfo(external_model.model);
  Eigen::VectorXd parameters = lens->Parameters();
  for (const std::string& missing : external_model.Missing())
    if (parameters[IndexOf(model, missing)] != 0) return std::nullopt;
  if (external_model.Has("f") && parameters[0] != parameters[1])
    return std::nullopt;
  parameters.segment<2>(2) = ToProgram(
      external_model.origin, lens->image_size(), parameters.segment<2>(2));
  ConvertedCamera held = {&external_model, lens->image_size(), {}, nullptr};
  for (const std::string& parameter : external_model.parameters)
    held.values.push_back(parameters[IndexOf(model, parameter)]);
  return held;
}

}  // namespace raygrid
