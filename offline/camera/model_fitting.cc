#include "camera/model_fitting.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "camera/central_generic.h"
#include "camera/central_radial.h"
#include "camera/decentring.h"
#include "camera/pose.h"

namespace raygrid {
namespace {

constexpr double kUnlimitedMarginPx =
    1e9;  // margin that accepts any projection
constexpr double kMissingErrorPx =
    100;  // error of samples without a projection

struct Sample {
  Eigen::Vector2d pixel;
  Eigen::Vector3d ray;
  bool is_valid = true;

  // Invalid pixels have a small weight, so that they only matter where no valid
  // pixel determines the model.
  double Weight() const { return is_valid ? 1 : 1e-3; }
};

// Adds rays of a lattice of across x across pixels: of valid pixels only, or of
// all pixels.
void AddRays(const CameraModel& camera, const Area& area, int across,
             const ValidityMask* valid_region, bool only_valid,
             std::vector<Sample>* samples) {
  for (int j = 0; j < across; ++j) {
    for (int i = 0; i < across; ++i) {
      const Eigen::Vector2d pixel(area.x0 + area.width() * i / (across - 1),
                                  area.y0 + area.height() * j / (across - 1));
      const bool is_valid = !valid_region || valid_region->IsValidAt(pixel);
      if (only_valid && !is_valid) continue;
      const auto ray = camera.Unproject(pixel);
      if (ray) samples->push_back({pixel, *ray, is_valid});
    }
  }
}

size_t CountValidSamples(const std::vector<Sample>& samples) {
  return std::count_if(samples.begin(), samples.end(),
                       [](const Sample& sample) { return sample.is_valid; });
}

std::vector<Sample> SampleRays(const CameraModel& camera, const Area& area,
                               const ValidityMask* valid_region) {
  constexpr int kSamplesAcross = 40, kMaxAcross = 320;
  constexpr size_t kEnough = 400;
  std::vector<Sample> samples;
  AddRays(camera, area, kSamplesAcross, valid_region, false, &samples);
  for (int across = 2 * kSamplesAcross;
       across <= kMaxAcross && CountValidSamples(samples) < kEnough;
       across *= 2)
    AddRays(camera, area, across, valid_region, true, &samples);
  return samples;
}

// Returns the rotation that maps the area's centre to the z axis and its pixel
// row to the x direction: an initial value independent of the camera frame.
Eigen::Quaterniond ComputeLevelRotation(const CameraModel& camera,
                                        const Area& area) {
  constexpr double kRelativeStep = 0.05;
  const Eigen::Vector2d step(kRelativeStep * area.width(), 0);
  const auto center = camera.Unproject(area.center());
  const auto right = camera.Unproject(area.center() + step);
  if (!center || !right) return Eigen::Quaterniond::Identity();
  Eigen::Matrix3d level_from_camera;
  level_from_camera.row(2) = center->transpose();
  level_from_camera.row(0) =
      (*right - center->dot(*right) * *center).normalized().transpose();
  level_from_camera.row(1) =
      level_from_camera.row(2).cross(level_from_camera.row(0));
  return Eigen::Quaterniond(level_from_camera);
}

// Principal point of the rotated camera and the focal length there; estimated
// from the extent of the samples if the camera has no ray along z.
struct Center {
  Eigen::Vector2d pixel;
  double focal_px;
};

Center EstimateCenter(const CameraModel& camera,
                      const Eigen::Quaterniond& rotation, const Area& area,
                      const std::vector<Sample>& samples) {
  const Eigen::Matrix3d matrix = rotation.toRotationMatrix();
  LinearizedProjection linear;
  if (camera.Linearize(matrix.row(2).transpose(), nullptr, 0, &linear)) {
    const Eigen::Matrix<double, 2, 3> J_rotated =
        linear.J_point * matrix.transpose();
    return {linear.pixel,
            std::sqrt(std::abs(J_rotated.leftCols<2>().determinant()))};
  }
  double widest = 0.1;
  for (const Sample& sample : samples)
    widest = std::max(
        widest,
        std::acos(std::clamp(sample.ray.dot(samples.front().ray), -1.0, 1.0)));
  return {area.center(), std::hypot(area.width(), area.height()) / widest};
}

std::vector<std::unique_ptr<ParametricModel>> MakeInitialModels(
    const std::string& name, const CameraModel& camera, const Center& center,
    const std::vector<Sample>& samples, int num_knots) {
  const double f = center.focal_px, cx = center.pixel.x(),
               cy = center.pixel.y();
  const ImageSize& size = camera.image_size();
  const Area& area = camera.area();
  std::vector<std::unique_ptr<ParametricModel>> starts;
  const ModelInfo& model = *FindModelInfo(name);
  if (model.make) {
    for (const Eigen::VectorXd& parameters : model.starts(f, cx, cy))
      starts.push_back(model.make(size, area, parameters));
  } else {
    double widest = 0.1;
    for (const Sample& sample : samples)
      widest = std::max(
          widest, std::atan2(sample.ray.head<2>().norm(), sample.ray.z()));
    starts.push_back(std::make_unique<CentralRadial>(
        size, area, std::min(1.05 * widest, 3.1),
        std::vector<double>(num_knots, 0),
        CentralRadial::PlanarParameters{f, f, cx, cy, 0, 0, 0, 0}));
  }
  return starts;
}

// Data of a fit, and the regularization of the distortion: the weighted sum of
// squared deviations of the parameters from their initial values.
struct Target {
  std::vector<Sample> samples;
  Eigen::VectorXd start;
  Eigen::VectorXd distortion_weights;
  double missing_error_px = kMissingErrorPx;  // larger errors are truncated
};

double DistortionCost(const CameraModel& model, const Target& target) {
  return (model.Parameters() - target.start)
      .cwiseAbs2()
      .dot(target.distortion_weights);
}

// Normal equations; the rotation update is the last parameter block.
struct Equations {
  double cost = 0;
  Eigen::MatrixXd normal;
  Eigen::VectorXd gradient;
};

// Returns the reprojection errors of all samples that have a projection.
std::vector<double> ComputeErrorsPx(const CameraModel& model,
                                    const Eigen::Quaterniond& rotation,
                                    const Target& target) {
  std::vector<double> errors;
  for (const Sample& sample : target.samples) {
    const auto pixel =
        model.Project(rotation * sample.ray, nullptr, kUnlimitedMarginPx);
    errors.push_back(pixel ? std::min((*pixel - sample.pixel).norm(),
                                      target.missing_error_px)
                           : target.missing_error_px);
  }
  return errors;
}

double ComputeCost(const CameraModel& model, const Eigen::Quaterniond& rotation,
                   const Target& target) {
  double cost = DistortionCost(model, target);
  const std::vector<double> errors = ComputeErrorsPx(model, rotation, target);
  for (size_t k = 0; k < errors.size(); ++k)
    cost += target.samples[k].Weight() * errors[k] * errors[k];
  return cost;
}

// Regularizes unobservable parameters, such as spline coefficients outside the
// range of the samples, towards smoothness.
void AddRidge(const ParametricModel& model, Equations* equations) {
  constexpr double kWeightPx = 1e-3;
  const Eigen::VectorXd parameters = model.Parameters();
  const int num_spline =
      static_cast<int>(parameters.size() - model.ParameterNames().size());
  for (int first = 0; first + 2 < num_spline; ++first) {
    const int at[3] = {first, first + 1, first + 2};
    const double factor[3] = {1, -2, 1};
    double difference = 0;
    for (int k = 0; k < 3; ++k) difference += factor[k] * parameters[at[k]];
    const double scale = kWeightPx * parameters[num_spline];
    for (int j = 0; j < 3; ++j) {
      equations->gradient[at[j]] += scale * scale * factor[j] * difference;
      for (int k = 0; k < 3; ++k)
        equations->normal(at[j], at[k]) +=
            scale * scale * factor[j] * factor[k];
    }
  }
}

void AddDistortion(const ParametricModel& model, const Target& target,
                   Equations* equations) {
  const Eigen::VectorXd& weights = target.distortion_weights;
  const Eigen::Index count = weights.size();
  equations->normal.diagonal().head(count) += weights;
  equations->gradient.head(count) +=
      weights.cwiseProduct(model.Parameters() - target.start);
}

Equations Linearize(const ParametricModel& model,
                    const Eigen::Quaterniond& rotation, const Target& target) {
  const int num_parameters = model.NumParameters(), size = num_parameters + 3;
  Equations equations;
  equations.normal.setZero(size, size);
  equations.gradient.setZero(size);
  Eigen::MatrixX2d by_parameters(size, 2);  // Jacobian of pixel x and y
  by_parameters.setZero();
  std::vector<int> affecting;  // indices of non-zero Jacobian rows: few for
                               // splines
  for (const Sample& sample : target.samples) {
    const Eigen::Vector3d ray = rotation * sample.ray;
    LinearizedProjection linear;
    if (!model.Linearize(ray, nullptr, kUnlimitedMarginPx, &linear)) continue;
    const Eigen::Vector2d error = linear.pixel - sample.pixel;
    if (error.norm() > target.missing_error_px) continue;
    for (int k = 0; k < linear.num_nodes; ++k) {
      by_parameters.row(linear.node_parameter[k]) +=
          linear.node_weight[k] * linear.J_node.col(0);
      affecting.push_back(linear.node_parameter[k]);
    }
    by_parameters.middleRows(linear.first_global, linear.num_global) =
        linear.J_global.leftCols(linear.num_global).transpose();
    for (int k = 0; k < 3; ++k)
      by_parameters.row(num_parameters + k) =
          linear.J_point * Eigen::Vector3d::Unit(k).cross(ray);
    for (int k = 0; k < linear.num_global; ++k)
      affecting.push_back(linear.first_global + k);
    for (int k = num_parameters; k < size; ++k) affecting.push_back(k);
    std::sort(affecting.begin(), affecting.end());
    affecting.erase(std::unique(affecting.begin(), affecting.end()),
                    affecting.end());
    for (const int k : affecting)
      by_parameters.row(k) *= std::sqrt(sample.Weight());
    for (const int k : affecting) {
      for (const int l : affecting) {
        if (l > k) break;  // upper triangle only
        equations.normal(l, k) += by_parameters(l, 0) * by_parameters(k, 0) +
                                  by_parameters(l, 1) * by_parameters(k, 1);
      }
      equations.gradient[k] +=
          std::sqrt(sample.Weight()) * by_parameters.row(k).dot(error);
    }
    for (const int k : affecting) by_parameters.row(k).setZero();
    affecting.clear();
  }
  equations.normal.triangularView<Eigen::StrictlyLower>() =
      equations.normal.transpose();
  AddRidge(model, &equations);
  AddDistortion(model, target, &equations);
  return equations;
}

// Parameters that are optimized in a fit.
struct FreeParameterSet {
  std::vector<Eigen::Index> parameters;  // the rotation follows them
  bool ties_focal_lengths = false;       // fy equals fx and is not a free
                                         // parameter
  bool rotation = false;
};

FreeParameterSet SelectFreeParameters(const ParametricModel& model,
                                      const FitOptions& options) {
  FreeParameterSet freedom;
  freedom.ties_focal_lengths = options.ties_focal_lengths;
  freedom.rotation = options.free_rotation;
  const int first = FirstCommonParameter(model);
  const std::vector<std::string>& names = model.ParameterNames();
  for (int k = 0; k < model.NumParameters(); ++k) {
    const std::string name = k < first ? "" : names[k - first];
    const bool is_fixed = std::find(options.held.begin(), options.held.end(),
                                    name) != options.held.end();
    if (is_fixed || (name == "fy" && freedom.ties_focal_lengths)) continue;
    freedom.parameters.push_back(k);
  }
  if (freedom.rotation)
    for (int k = 0; k < 3; ++k)
      freedom.parameters.push_back(model.NumParameters() + k);
  return freedom;
}

// Computes the damped step of the free parameters and the rotation.
Eigen::VectorXd Step(const ParametricModel& model,
                     const FreeParameterSet& freedom,
                     const Equations& equations, double lambda) {
  const std::vector<Eigen::Index>& free = freedom.parameters;
  const Eigen::Index fx = FirstCommonParameter(model), fy = fx + 1;
  Eigen::MatrixXd normal = equations.normal;
  Eigen::VectorXd gradient = equations.gradient;
  if (freedom.ties_focal_lengths) {
    normal.row(fx) += normal.row(fy).eval();
    normal.col(fx) += normal.col(fy).eval();
    gradient[fx] += gradient[fy];
  }
  Eigen::MatrixXd damped = normal(free, free);
  damped.diagonal() *= 1 + lambda;
  damped.diagonal().array() += 1e-12;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(gradient.size());
  step(free) = -damped.ldlt().solve(gradient(free));
  if (freedom.ties_focal_lengths) step[fy] = step[fx];
  return step;
}

// Runs Levenberg-Marquardt until a step reduces the cost by less than this
// fraction. Returns the cost.
double Refine(const Target& target, const FreeParameterSet& freedom,
              double converged_fraction, FittedModel* fit) {
  constexpr int kMaxIterations = 100;
  ParametricModel& model = *fit->model;
  double cost = ComputeCost(model, fit->model_from_camera, target),
         lambda = 1e-4;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Equations equations =
        Linearize(model, fit->model_from_camera, target);
    const double before = cost;
    for (; lambda < 1e10; lambda *= 10) {
      const Eigen::VectorXd step = Step(model, freedom, equations, lambda);
      if (!step.allFinite()) continue;
      const std::unique_ptr<CameraModel> next = model.Clone();
      next->SetParameters(model.Parameters() +
                          step.head(model.NumParameters()));
      Eigen::Quaterniond rotation = fit->model_from_camera;
      if (freedom.rotation)
        rotation = (RotationFromVector(step.tail<3>()) * rotation).normalized();
      const double next_cost = ComputeCost(*next, rotation, target);
      if (!(next_cost < cost)) continue;
      model.SetParameters(next->Parameters());
      fit->model_from_camera = rotation;
      cost = next_cost;
      lambda = std::max(lambda / 10, 1e-12);
      break;
    }
    if (!(cost < (1 - converged_fraction) * before)) break;
  }
  return cost;
}

// Returns the given fraction of the errors of valid samples, the smallest ones,
// in ascending order.
std::vector<double> SelectSmallestErrors(const FittedModel& fit,
                                         const Target& target, double part) {
  const std::vector<double> all =
      ComputeErrorsPx(*fit.model, fit.model_from_camera, target);
  std::vector<double> errors;
  for (size_t k = 0; k < all.size(); ++k)
    if (target.samples[k].is_valid) errors.push_back(all[k]);
  std::sort(errors.begin(), errors.end());
  errors.resize(static_cast<size_t>(
      std::ceil(part * static_cast<double>(errors.size()))));
  return errors;
}

double RmsPx(const FittedModel& fit, const Target& target) {
  const std::vector<double> errors =
      SelectSmallestErrors(fit, target, FittedModel::kInlierFraction);
  double sum = 0;
  for (const double error : errors) sum += error * error;
  return errors.empty() ? 0
                        : std::sqrt(sum / static_cast<double>(errors.size()));
}

// Computes the weights of the regularization: a corner displacement of 1 px
// costs as much as errors of bend_px (radial terms) or tilt_px (tilt terms) at
// all samples.
Eigen::VectorXd DistortionWeights(const ParametricModel& start,
                                  const Area& area, double num_samples,
                                  double bend_px, double tilt_px) {
  const Eigen::VectorXd parts =
      bend_px * ComputeRadialDisplacement(start, area) +
      tilt_px * ComputeDecentringDisplacement(start, area);
  return num_samples * parts.cwiseAbs2();
}

// Optimizes in rounds. With a free rotation, tilt parameters are regularized,
// at first for a lens with local distortion, then according to the remaining
// error; outliers, such as corners of a grid without observations, then have no
// weight. Radial parameters are almost free in the first round and then weakly
// regularized, because coefficients of numerator and denominator can compensate
// each other. Returns the cost without the regularization.
double RefineInRounds(const Area& area, const FreeParameterSet& freedom,
                      Target* target, FittedModel* fit) {
  constexpr int kRounds = 4;
  constexpr double kFirstRmsPx = 1.0 / 3, kMissingErrorPerMedian = 10,
                   kMinMissingErrorPx = 1;
  constexpr double kRoundTolerance = 1e-6, kConverged = 1e-10;
  constexpr double kRelativeRadialTolerance = 3e-4, kMinRadialFraction = 1e-7;
  double num_samples = 0;
  for (const Sample& sample : target->samples) num_samples += sample.Weight();
  const std::unique_ptr<ParametricModel> start =
      fit->model->CloneWithArea(fit->model->area());
  target->start = start->Parameters();
  target->missing_error_px = kMissingErrorPx;
  double rms_px = kFirstRmsPx, bend_px = kMinRadialFraction;
  for (int round = 0; round < kRounds; ++round) {
    target->distortion_weights = DistortionWeights(
        *start, area, num_samples, bend_px,
        freedom.rotation ? kMaxDecentringFraction * rms_px : 0);
    Refine(*target, freedom, round + 1 < kRounds ? kRoundTolerance : kConverged,
           fit);
    rms_px = RmsPx(*fit, *target);
    bend_px = std::max(kRelativeRadialTolerance * std::min(rms_px, kFirstRmsPx),
                       kMinRadialFraction);
    const std::vector<double> half = SelectSmallestErrors(*fit, *target, 0.5);
    if (!half.empty() && freedom.rotation)
      target->missing_error_px =
          std::clamp(kMissingErrorPerMedian * half.back(), kMinMissingErrorPx,
                     kMissingErrorPx);
  }
  target->missing_error_px = kMissingErrorPx;
  target->distortion_weights.setZero();
  return freedom.rotation
             ? RmsPx(*fit, *target)
             : ComputeCost(*fit->model, fit->model_from_camera, *target);
}

// Whether the parameters to be held constant are 0 in a model.
bool HasNoFixedTerms(const ParametricModel& lens,
                     const std::vector<std::string>& held) {
  const std::vector<std::string>& names = lens.ParameterNames();
  const Eigen::VectorXd named = lens.Parameters().tail(names.size());
  for (size_t k = 0; k < names.size(); ++k)
    if (named[k] != 0 &&
        std::find(held.begin(), held.end(), names[k]) != held.end())
      return false;
  return true;
}

// Returns the initial values in which the fixed parameters are 0; if there are
// none, all initial values, with these parameters set to 0.
std::vector<std::unique_ptr<ParametricModel>> RemoveFixedTerms(
    std::vector<std::unique_ptr<ParametricModel>> starts,
    const std::vector<std::string>& held) {
  std::vector<std::unique_ptr<ParametricModel>> without;
  for (auto& start : starts)
    if (HasNoFixedTerms(*start, held)) without.push_back(std::move(start));
  if (!without.empty()) return without;
  for (auto& start : starts) {
    Eigen::VectorXd parameters = start->Parameters();
    const std::vector<std::string>& names = start->ParameterNames();
    for (const std::string& name : held)
      parameters.tail(
          names.size())[std::find(names.begin(), names.end(), name) -
                        names.begin()] = 0;
    start->SetParameters(parameters);
  }
  return starts;
}

}  // namespace

FittedModel FitParametricModel(const std::string& name,
                               const CameraModel& camera, const Area& area,
                               const FitOptions& options) {
  if (!camera.IsCentral() && camera.DirectionGrid())
    return FitParametricModel(name, MakeCentral(camera), area, options);
  const Eigen::Quaterniond start_from_camera =
      options.free_rotation ? ComputeLevelRotation(camera, area)
                            : Eigen::Quaterniond::Identity();
  Target target;
  target.samples = SampleRays(camera, area, options.valid_region);
  for (Sample& sample : target.samples)
    sample.ray = start_from_camera * sample.ray;
  const Center center =
      EstimateCenter(camera, start_from_camera, area, target.samples);
  FittedModel best;
  double best_cost = INFINITY;
  for (auto& start :
       RemoveFixedTerms(MakeInitialModels(name, camera, center, target.samples,
                                          options.num_knots),
                        options.held)) {
    FittedModel fit;
    fit.model = std::move(start);
    const double cost = RefineInRounds(
        area, SelectFreeParameters(*fit.model, options), &target, &fit);
    if (best.model && !(cost < best_cost)) continue;
    best = std::move(fit);
    best_cost = cost;
  }
  best.rms_px = RmsPx(best, target);
  best.model_from_camera =
      (best.model_from_camera * start_from_camera).normalized();
  return best;
}

FittedModel FitNearestModel(const std::string& name, const CameraModel& camera,
                            const Area& area, FitOptions options) {
  constexpr double kMinImprovementFraction = 0.02, kNegligibleRmsPx = 0.005;
  options.free_rotation = false;
  FittedModel level = FitParametricModel(name, camera, area, options);
  if (level.rms_px <= kNegligibleRmsPx) return level;
  options.free_rotation = true;
  FittedModel turned = FitParametricModel(name, camera, area, options);
  return turned.rms_px < (1 - kMinImprovementFraction) * level.rms_px
             ? std::move(turned)
             : std::move(level);
}

}  // namespace raygrid
