#include "experiments/calibrated_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/calibration.h"
#include "camera/model_fitting.h"
#include "dataset/error.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

constexpr int kHoldOutEvery = 5;

std::vector<std::string> SelectEveryFifth(const Dataset& dataset) {
  std::vector<std::string> images;
  for (size_t i = kHoldOutEvery - 1; i < dataset.images.size();
       i += kHoldOutEvery)
    images.push_back(dataset.images[i].image);
  return images;
}

std::vector<Condition> ReadOperatingPoints(const ExperimentFeatures& features,
                                           const std::string& source) {
  const Dataset& dataset = features.dataset;
  return {
      {"features",
       fmt::format("{} {}, in {} images of {} x {} px", dataset.num_features(),
                   source, dataset.images.size(), dataset.image_size.width,
                   dataset.image_size.height)},
      {"held out", fmt::format("{} of the images", features.hold_out.size())}};
}

constexpr char kCalibrationNote[] =
    "target geometry estimated, knot spacing by cross-validation, as in "
    "calibrate";

// Uses the last camera as the reference, and states this in the conditions
// (paper, "Camera Pose Estimation").
void UseLastAsReference(const std::string& others, ComparedCameras* compared) {
  NamedCamera& truth = compared->cameras.back();
  compared->conditions.push_back(
      {"truth",
       fmt::format(
           "not available; {} serves as reference, {}; evaluated where its "
           "predicted uncertainty is below {:g} px or below its median",
           truth.name, others, kKnownPx)});
  truth.name += " (reference)";
}

ComparedCameras SelectUserCameras(const std::vector<NamedCamera>& users) {
  constexpr size_t kMaxCameras = 6;  // the maximum for a chart
  if (users.size() > kMaxCameras)
    throw Error(ExitCode::kUsage,
                fmt::format("--camera: {} cameras exceed the limit of {}",
                            users.size(), kMaxCameras));
  for (const NamedCamera& camera : users)
    if (camera.model->image_size() != users[0].model->image_size())
      throw InputError(
          fmt::format("{}: its image size differs from that of {}; use cameras "
                      "of the same sensor mode",
                      camera.name, users[0].name));
  ComparedCameras compared;
  if (users.size() == 1)
    for (FittedCamera& fit : FitModels(users[0]))
      compared.cameras.push_back(std::move(fit.camera));
  else
    compared.cameras.assign(users.begin(), users.end() - 1);
  compared.cameras.push_back(users.back());
  UseLastAsReference(
      users.size() == 1 ? "the others are fitted to it" : "the others as given",
      &compared);
  return compared;
}

}  // namespace

ExperimentFeatures SelectFeatures(const ExperimentOptions& options,
                                  const std::string& lens) {
  ExperimentFeatures features;
  if (options.data.features) {
    features.dataset = *options.data.features;
    features.pattern = options.data.pattern;
    features.hold_out = options.data.hold_out;
    if (features.hold_out.empty())
      features.hold_out = SelectEveryFifth(features.dataset);
    features.conditions = ReadOperatingPoints(features, "(own data)");
    return features;
  }
  SimulationOptions simulation;
  simulation.num_images = options.num_images;
  simulation.seed = options.seed + 1;
  features.truth = MakeSimulatedCamera(lens, options.size);
  features.pattern = ChessboardPattern(30, 24, 0.02);
  features.dataset =
      SimulateObservations(*features.truth, features.pattern, simulation)
          .dataset;
  features.hold_out = SelectEveryFifth(features.dataset);
  features.conditions = ReadOperatingPoints(features, "simulated");
  features.conditions.push_back({"lens", lens});
  features.conditions.push_back(
      {"noise", fmt::format("{:g} px per axis", simulation.noise_px)});
  features.conditions.push_back({"seed", std::to_string(options.seed)});
  return features;
}

std::string ModelChoice::Label() const {
  return cells > 0 ? fmt::format("{}/{}", model, cells) : model;
}

CalibrationResult CalibrateModel(const ExperimentFeatures& features,
                                 const ModelChoice& choice,
                                 const ExperimentOptions& options) {
  if (features.hold_out.empty())
    throw Error(ExitCode::kInsufficientData,
                "too few images to hold some out; use at least five");
  const ImageSize& size = features.dataset.image_size;
  CalibrationOptions calibration;
  calibration.model = choice.model;
  if (choice.cells > 0)
    calibration.knot_spacing_px =
        std::max(2.0, double(std::max(size.width, size.height)) / choice.cells);
  calibration.hold_out = features.hold_out;
  calibration.num_threads = options.num_threads;
  return Calibrate(features.dataset, features.pattern, calibration);
}

std::optional<ValidityMask> ComputeWellDeterminedMask(const CameraFile& file) {
  if (!file.uncertainty) return std::nullopt;
  const UncertaintyLattice& lattice = file.uncertainty->lattice;
  if (lattice.stddev_px.empty()) return file.uncertainty->mask;
  const double limit_px = std::max(kKnownPx, lattice.MedianPx());
  ValidityMask known = ValidityMask::Over(file.camera->image_size());
  for (size_t k = 0; k < known.is_valid.size(); ++k)
    known.is_valid[k] =
        lattice.At(file.camera->area(),
                   known.CellCenter(static_cast<int>(k))) <= limit_px;
  return known;
}

std::vector<FittedCamera> FitModels(const NamedCamera& camera) {
  std::vector<FittedCamera> fits;
  FitOptions fit;
  fit.free_rotation = true;
  if (camera.known && camera.known->HasValidCells())
    fit.valid_region = &*camera.known;
  for (const std::string& name : ListModelNames(ModelUse::kCompare)) {
    FittedModel fitted =
        FitParametricModel(name, *camera.model, camera.model->area(), fit);
    if (std::isfinite(fitted.rms_px))
      fits.push_back({{name, std::move(fitted.model), std::nullopt},
                      fitted.model_from_camera});
  }
  if (fits.empty())
    throw Error(ExitCode::kInitializationFailed,
                camera.name + ": no parametric model fits this camera");
  return fits;
}

ComparedCameras SelectComparedCameras(const ExperimentOptions& options,
                                      const std::vector<std::string>& models) {
  if (!options.data.cameras.empty())
    return SelectUserCameras(options.data.cameras);
  const ExperimentFeatures features = SelectFeatures(options);
  ComparedCameras compared;
  compared.conditions = features.conditions;
  compared.conditions.push_back({"calibrated", kCalibrationNote});
  for (const std::string& model : models) {
    try {
      const CameraFile file = CalibrateModel(features, {model}, options).camera;
      compared.cameras.push_back(
          {model, file.camera, ComputeWellDeterminedMask(file)});
    } catch (const Error& error) {
      compared.conditions.push_back({model, error.what()});
    }
    if (options.progress)
      options.progress(0.5 * double(compared.cameras.size()) /
                       double(models.size()));
  }
  if (compared.cameras.empty())
    throw Error(ExitCode::kInitializationFailed,
                "no model could be calibrated");
  if (features.truth)
    compared.cameras.push_back({"truth", features.truth, std::nullopt});
  else
    UseLastAsReference("the others calibrated from the same features",
                       &compared);
  return compared;
}

bool AreAllDefined(const ComparedCameras& compared,
                   const Eigen::Vector2d& pixel) {
  const auto& known = compared.cameras.back().known;
  if (known && !known->IsValidAt(pixel)) return false;
  return std::all_of(compared.cameras.begin(), compared.cameras.end(),
                     [&pixel](const NamedCamera& camera) {
                       return camera.model->Line(pixel).has_value();
                     });
}

Area ComputeCommonArea(const std::vector<NamedCamera>& cameras) {
  Area area = cameras.front().model->area();
  for (const NamedCamera& camera : cameras) {
    const Area& own = camera.model->area();
    area = {std::max(area.x0, own.x0), std::max(area.y0, own.y0),
            std::min(area.x1, own.x1), std::min(area.y1, own.y1)};
  }
  return area;
}

}  // namespace raygrid
