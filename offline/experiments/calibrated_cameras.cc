#include "experiments/calibrated_cameras.h"

#include <fmt/format.h>

#include <algorithm>

#include "calibration/calibration.h"
#include "dataset/error.h"
#include "simulation/simulated_lenses.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

constexpr int kHoldOutEvery = 5;

std::vector<std::string> EveryFifth(const Dataset& dataset) {
  std::vector<std::string> images;
  for (size_t i = kHoldOutEvery - 1; i < dataset.images.size();
       i += kHoldOutEvery)
    images.push_back(dataset.images[i].image);
  return images;
}

std::vector<Condition> ConditionsOf(const ExperimentFeatures& features,
                                    const std::string& source) {
  const Dataset& dataset = features.dataset;
  return {
      {"features",
       fmt::format("{} {}, in {} images of {} x {} px", dataset.num_features(),
                   source, dataset.images.size(), dataset.image_size.width,
                   dataset.image_size.height)},
      {"held out", fmt::format("{} of the images", features.hold_out.size())}};
}

}  // namespace

ExperimentFeatures FeaturesFor(const ExperimentOptions& options,
                               const std::string& lens) {
  ExperimentFeatures features;
  if (options.data.features) {
    features.dataset = *options.data.features;
    features.pattern = options.data.pattern;
    features.hold_out = options.data.hold_out;
    if (features.hold_out.empty())
      features.hold_out = EveryFifth(features.dataset);
    features.conditions = ConditionsOf(features, "of the user's");
    return features;
  }
  SimulationOptions simulation;
  simulation.num_images = options.num_images;
  simulation.seed = options.seed + 1;
  features.truth = SimulatedLens(lens, options.size);
  features.pattern = ChessboardPattern(30, 24, 0.02);
  features.dataset =
      SimulateObservations(*features.truth, features.pattern, simulation)
          .dataset;
  features.hold_out = EveryFifth(features.dataset);
  features.conditions = ConditionsOf(features, "simulated");
  features.conditions.push_back({"lens", lens});
  features.conditions.push_back(
      {"noise", fmt::format("{:g} px in an axis", simulation.noise_px)});
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
    throw Error(ExitCode::kTooFew,
                "too few images to hold some out; take five or more");
  const ImageSize& size = features.dataset.image_size;
  CalibrationOptions calibration;
  calibration.model = choice.model;
  if (choice.cells > 0)
    calibration.cell_px =
        std::max(2.0, double(std::max(size.width, size.height)) / choice.cells);
  calibration.hold_out = features.hold_out;
  // A simulated board is flat, and told so, which saves time.
  calibration.flat_board = features.truth != nullptr;
  calibration.num_threads = options.num_threads;
  return Calibrate(features.dataset, features.pattern, calibration);
}

Area CommonArea(const std::vector<NamedCamera>& cameras) {
  Area area = cameras.front().model->area();
  for (const NamedCamera& camera : cameras) {
    const Area& own = camera.model->area();
    area = {std::max(area.x0, own.x0), std::max(area.y0, own.y0),
            std::min(area.x1, own.x1), std::min(area.y1, own.y1)};
  }
  return area;
}

}  // namespace raygrid
