#include "calibration/base_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/camera_adjustment.h"
#include "calibration/even_selection.h"
#include "camera/fixed_camera.h"

namespace raygrid {
namespace {

constexpr const char *kFisheye = models::kThinPrismFisheye,
                     *kPinhole = models::kOpenCv;

// Makes a base model from a fitted parametric model and the precision of its
// prior.
BaseModel MakeBaseModel(const CameraPrior& prior, const CameraModel& lens,
                        double residual_variance) {
  BaseModel base;
  base.model = lens.Parametric()->CloneWithArea(lens.area());
  base.precision = Eigen::VectorXd::Zero(lens.NumParameters());
  for (const PriorGroup& group : prior.groups)
    base.precision += group.weight / residual_variance *
                      Eigen::VectorXd(group.precision.diagonal());
  return base;
}

// Parametric models of one type for all cameras, fitted to the features.
struct FittedCameras {
  AdjustmentState state;
  std::vector<BaseModel> base_model_by_camera;  // empty if the fit failed
  double median_px = INFINITY;
};

FittedCameras FitCameras(const std::string& model,
                         const AdjustmentResult& adjusted,
                         const AdjustmentOptions& options) {
  FittedCameras fitted;
  fitted.state = adjusted.state;
  GaussianPrior prior;
  const AdjustmentSummary summary = OptimizeParametricCameras(
      model, adjusted.problem, CopyCameras(adjusted.state),
      MakeInitializationOptions(options), &prior, &fitted.state);
  fitted.median_px = ComputeMedianErrorPx(summary.residuals);
  for (size_t c = 0; c < prior.cameras.size() && summary.noise_px > 0; ++c)
    fitted.base_model_by_camera.push_back(
        IsFixed(*fitted.state.cameras[c])
            ? BaseModel()
            : MakeBaseModel(prior.cameras[c], *fitted.state.cameras[c],
                            std::pow(summary.noise_px, 2)));
  return fitted;
}

// Returns the expected log-likelihood of new features for coarse grids around
// the base models, up to a constant, by generalized cross-validation (Golub,
// Heath, Wahba, 1979). The better the base models fit, the fewer effective
// parameters a grid needs to reach the same residuals.
double ComputePredictionScore(const CalibrationProblem& problem,
                              const FittedCameras& fitted,
                              const AdjustmentOptions& options) {
  // Number of cells along the longer side. With 12 cells, splines are too
  // coarse for a lens with a field of view of 80 degrees.
  constexpr int kCells = 16;
  std::vector<double> knot_spacings_px;
  for (const ImageSize& size : problem.image_sizes)
    knot_spacings_px.push_back(std::max(size.width, size.height) /
                               static_cast<double>(kCells));
  AdjustmentState state = fitted.state;
  GaussianPrior prior;
  const AdjustmentSummary summary = OptimizeGrids(
      problem,
      {CopyCameras(state), knot_spacings_px, fitted.base_model_by_camera},
      MakeInitializationOptions(options), &prior, &state);
  double count = 0;
  for (const View& view : problem.views)
    count += 2.0 * static_cast<double>(view.observations.size());
  return -count * (std::log(summary.noise_px) -
                   std::log(1 - summary.num_effective / count) / 2);
}

bool AreAllPinholes(const AdjustmentState& state) {
  return std::all_of(
      state.cameras.begin(), state.cameras.end(),
      [](const auto& camera) { return camera->Name() == kPinhole; });
}

}  // namespace

std::string ChooseBaseModel(const AdjustmentOptions& options,
                            const AdjustmentResult& adjusted) {
  constexpr double kMinLogLikelihoodGain = 10;  // difference in log-likelihood
  constexpr size_t kMinFeatures = 100;          // features kept per view
  if (!AreAllPinholes(adjusted.state)) return kFisheye;
  AdjustmentResult subsampled = adjusted;
  for (View& view : subsampled.problem.views)
    view.observations = SelectEvenly(view.observations, kMinFeatures);
  const FittedCameras fisheye_fit = FitCameras(kFisheye, subsampled, options);
  const FittedCameras pinhole_fit = FitCameras(kPinhole, subsampled, options);
  if (pinhole_fit.base_model_by_camera.empty()) return kFisheye;
  if (fisheye_fit.base_model_by_camera.empty()) return kPinhole;
  const auto score = [&](const FittedCameras& fitted) {
    return ComputePredictionScore(subsampled.problem, fitted, options);
  };
  return score(pinhole_fit) > score(fisheye_fit) + kMinLogLikelihoodGain
             ? kPinhole
             : kFisheye;
}

void FitBaseModels(const AdjustmentOptions& options,
                   AdjustmentResult* adjusted) {
  constexpr double kMaxErrorRatio = 2;
  CalibrationProblem& problem = adjusted->problem;
  const double before_px = ComputeMedianErrorPx(
      ComputeResiduals(adjusted->state, problem.views, options.num_threads));
  if (problem.base_model.empty())
    problem.base_model = ChooseBaseModel(options, *adjusted);
  FittedCameras fitted = FitCameras(problem.base_model, *adjusted, options);
  adjusted->base_models.clear();
  if (fitted.median_px > kMaxErrorRatio * before_px) return;
  adjusted->state = std::move(fitted.state);
  adjusted->base_models = std::move(fitted.base_model_by_camera);
}

}  // namespace raygrid
