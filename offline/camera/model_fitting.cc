#include "camera/model_fitting.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "camera/central_radial.h"
#include "camera/decentring.h"
#include "camera/noncentral_generic.h"
#include "camera/opencv.h"
#include "camera/pose.h"
#include "camera/thin_prism_fisheye.h"

namespace raygrid {
namespace {

constexpr int kSplineParameters = 24;
constexpr double kAnywherePx = 1e9;  // a margin
constexpr double kLostPx = 100;      // the error of what is not projected

struct Sample {
  Eigen::Vector2d pixel;
  Eigen::Vector3d ray;
};

std::vector<Sample> SampleRays(const CameraModel& camera, const Area& area) {
  constexpr int kAcross = 40;
  std::vector<Sample> samples;
  for (int j = 0; j < kAcross; ++j) {
    for (int i = 0; i < kAcross; ++i) {
      const Eigen::Vector2d pixel(area.x0 + area.width() * i / (kAcross - 1),
                                  area.y0 + area.height() * j / (kAcross - 1));
      const auto ray = camera.Unproject(pixel);
      if (ray) samples.push_back({pixel, *ray});
    }
  }
  return samples;
}

// The rotation after which the middle of the area looks straight ahead and its
// row of pixels along x: a start that does not depend on the camera's own
// frame.
Eigen::Quaterniond LevelFromCamera(const CameraModel& camera,
                                   const Area& area) {
  constexpr double kStepPart = 0.05;
  const Eigen::Vector2d step(kStepPart * area.width(), 0);
  const auto middle = camera.Unproject(area.center());
  const auto right = camera.Unproject(area.center() + step);
  if (!middle || !right) return Eigen::Quaterniond::Identity();
  Eigen::Matrix3d level_from_camera;
  level_from_camera.row(2) = middle->transpose();
  level_from_camera.row(0) =
      (*right - middle->dot(*right) * *middle).normalized().transpose();
  level_from_camera.row(1) =
      level_from_camera.row(2).cross(level_from_camera.row(0));
  return Eigen::Quaterniond(level_from_camera);
}

// The pixel at which the turned camera looks straight ahead, and its focal
// length there; from the samples' spread if it does not look straight ahead.
struct Center {
  Eigen::Vector2d pixel;
  double focal_px;
};

Center CenterOf(const CameraModel& camera, const Eigen::Quaterniond& rotation,
                const Area& area, const std::vector<Sample>& samples) {
  const Eigen::Matrix3d matrix = rotation.toRotationMatrix();
  LinearizedProjection linear;
  if (camera.Linearize(matrix.row(2).transpose(), nullptr, 0, &linear)) {
    const Eigen::Matrix<double, 2, 3> by_turned =
        linear.by_point * matrix.transpose();
    return {linear.pixel,
            std::sqrt(std::abs(by_turned.leftCols<2>().determinant()))};
  }
  double widest = 0.1;
  for (const Sample& sample : samples)
    widest = std::max(
        widest,
        std::acos(std::clamp(sample.ray.dot(samples.front().ray), -1.0, 1.0)));
  return {area.center(), std::hypot(area.width(), area.height()) / widest};
}

std::vector<std::unique_ptr<ParametricModel>> Starts(
    const std::string& name, const CameraModel& camera, const Center& center,
    const std::vector<Sample>& samples) {
  const double f = center.focal_px, cx = center.pixel.x(),
               cy = center.pixel.y();
  const ImageSize& size = camera.image_size();
  const Area& area = camera.area();
  std::vector<std::unique_ptr<ParametricModel>> starts;
  if (name == "opencv") {
    starts.push_back(std::make_unique<OpenCvModel>(
        size, area,
        OpenCvModel::ParameterArray{f, f, cx, cy, 0, 0, 0, 0, 0, 0, 0, 0}));
    // Pade's approximation of atan(r) / r: an equidistant lens.
    starts.push_back(std::make_unique<OpenCvModel>(
        size, area,
        OpenCvModel::ParameterArray{f, f, cx, cy, 1190 / 1155.0, 231 / 1155.0,
                                    0, 1575 / 1155.0, 525 / 1155.0, 25 / 1155.0,
                                    0, 0}));
  } else if (name == "thin-prism-fisheye") {
    starts.push_back(std::make_unique<ThinPrismFisheye>(
        size, area,
        ThinPrismFisheye::ParameterArray{f, f, cx, cy, 0, 0, 0, 0, 0, 0, 0,
                                         0}));
  } else {
    double widest = 0.1;
    for (const Sample& sample : samples)
      widest = std::max(
          widest, std::atan2(sample.ray.head<2>().norm(), sample.ray.z()));
    starts.push_back(std::make_unique<CentralRadial>(
        size, area, std::min(1.05 * widest, 3.1),
        std::vector<double>(kSplineParameters, 0),
        CentralRadial::OtherParameters{f, f, cx, cy, 0, 0, 0, 0}));
  }
  return starts;
}

// The target that a lens is fitted to, and the cost of its tilt: the sum of the
// squared parameters with these weights.
struct Target {
  std::vector<Sample> samples;
  Eigen::VectorXd decentring_weights;
  double lost_px = kLostPx;  // larger errors have no say
};

double DecentringCost(const ParametricModel& model, const Target& target) {
  return model.Parameters().cwiseAbs2().dot(target.decentring_weights);
}

// The least-squares problem; the rotation's update comes last.
struct Equations {
  double cost = 0;
  Eigen::MatrixXd normal;
  Eigen::VectorXd gradient;
};

// How far each sample is projected from its pixel, but for those that are lost.
std::vector<double> ErrorsPx(const ParametricModel& model,
                             const Eigen::Quaterniond& rotation,
                             const Target& target) {
  std::vector<double> errors;
  for (const Sample& sample : target.samples) {
    const auto pixel =
        model.Project(rotation * sample.ray, nullptr, kAnywherePx);
    errors.push_back(
        pixel ? std::min((*pixel - sample.pixel).norm(), target.lost_px)
              : target.lost_px);
  }
  return errors;
}

double CostOf(const ParametricModel& model, const Eigen::Quaterniond& rotation,
              const Target& target) {
  double cost = DecentringCost(model, target);
  for (const double error : ErrorsPx(model, rotation, target))
    cost += error * error;
  return cost;
}

// Adds equations that keep parameters of no effect, such as a spline's beyond
// the samples, smooth and small.
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

void AddDecentring(const ParametricModel& model, const Target& target,
                   Equations* equations) {
  const Eigen::VectorXd& weights = target.decentring_weights;
  const Eigen::Index count = weights.size();
  equations->normal.diagonal().head(count) += weights;
  equations->gradient.head(count) += weights.cwiseProduct(model.Parameters());
}

Equations Linearize(const ParametricModel& model,
                    const Eigen::Quaterniond& rotation, const Target& target) {
  const int num_parameters = model.NumParameters(), size = num_parameters + 3;
  Equations equations;
  equations.normal.setZero(size, size);
  equations.gradient.setZero(size);
  Eigen::Matrix2Xd row(2, size);
  for (const Sample& sample : target.samples) {
    const Eigen::Vector3d ray = rotation * sample.ray;
    LinearizedProjection linear;
    if (!model.Linearize(ray, nullptr, kAnywherePx, &linear)) continue;
    const Eigen::Vector2d error = linear.pixel - sample.pixel;
    if (error.norm() > target.lost_px) continue;
    row.setZero();
    for (int k = 0; k < linear.num_nodes; ++k)
      row.col(linear.node_parameter[k]) +=
          linear.node_weight[k] * linear.by_node.col(0);
    row.middleCols(linear.first_global, linear.num_global) =
        linear.by_global.leftCols(linear.num_global);
    for (int k = 0; k < 3; ++k)
      row.col(num_parameters + k) =
          linear.by_point * Eigen::Vector3d::Unit(k).cross(ray);
    // Small enough to be multiplied without the blocks of large products.
    equations.normal += row.transpose().lazyProduct(row);
    equations.gradient += row.transpose().lazyProduct(error);
  }
  AddRidge(model, &equations);
  AddDecentring(model, target, &equations);
  return equations;
}

// Levenberg-Marquardt. Returns the cost.
double Refine(const Target& target, bool free_rotation, FittedModel* fit) {
  constexpr int kMaxIterations = 100;
  constexpr double kConverged = 1e-10;
  ParametricModel& model = *fit->model;
  double cost = CostOf(model, fit->model_from_camera, target), lambda = 1e-4;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Equations equations =
        Linearize(model, fit->model_from_camera, target);
    const Eigen::Index size =
        equations.gradient.size() - (free_rotation ? 0 : 3);
    const double before = cost;
    for (; lambda < 1e10; lambda *= 10) {
      Eigen::MatrixXd damped = equations.normal.topLeftCorner(size, size);
      damped.diagonal() *= 1 + lambda;
      damped.diagonal().array() += 1e-12;
      const Eigen::VectorXd step =
          -damped.ldlt().solve(equations.gradient.head(size));
      if (!step.allFinite()) continue;
      const std::unique_ptr<CameraModel> next = model.Clone();
      const Eigen::Index count = model.NumParameters();
      next->SetParameters(model.Parameters() + step.head(count));
      Eigen::Quaterniond rotation = fit->model_from_camera;
      if (free_rotation)
        rotation = (RotationFromVector(step.tail<3>()) * rotation).normalized();
      const double next_cost =
          CostOf(dynamic_cast<const ParametricModel&>(*next), rotation, target);
      if (!(next_cost < cost)) continue;
      model.SetParameters(next->Parameters());
      fit->model_from_camera = rotation;
      cost = next_cost;
      lambda = std::max(lambda / 10, 1e-12);
      break;
    }
    if (!(cost < (1 - kConverged) * before)) break;
  }
  return cost;
}

// The errors of the samples that are fitted best, which are this part of all,
// from the smallest on.
std::vector<double> SmallestErrors(const FittedModel& fit, const Target& target,
                                   double part) {
  std::vector<double> errors =
      ErrorsPx(*fit.model, fit.model_from_camera, target);
  std::sort(errors.begin(), errors.end());
  errors.resize(static_cast<size_t>(
      std::ceil(part * static_cast<double>(errors.size()))));
  return errors;
}

double RmsPx(const FittedModel& fit, const Target& target) {
  const std::vector<double> errors =
      SmallestErrors(fit, target, FittedModel::kCountedPart);
  double sum = 0;
  for (const double error : errors) sum += error * error;
  return errors.empty() ? 0
                        : std::sqrt(sum / static_cast<double>(errors.size()));
}

// Against a rotation that is free, the lens's tilt is held, at first as a lens
// with bumps needs it, then as firmly as what it leaves asks for. What is far
// off the rest then has no say: a grid's corners that nothing was seen in.
// Returns what is left.
double RefineWithRotation(const Area& area, Target* target, FittedModel* fit) {
  constexpr int kRounds = 4;
  constexpr double kFirstRmsPx = 1.0 / 3, kFarOff = 10, kNeverFarOffPx = 1;
  const Eigen::VectorXd pixels = DecentringPixels(*fit->model, area);
  double rms_px = kFirstRmsPx;
  target->lost_px = kLostPx;
  for (int round = 0; round < kRounds; ++round) {
    target->decentring_weights =
        static_cast<double>(target->samples.size()) *
        (kDecentringPart * rms_px * pixels).cwiseAbs2();
    Refine(*target, true, fit);
    rms_px = RmsPx(*fit, *target);
    const std::vector<double> half = SmallestErrors(*fit, *target, 0.5);
    if (!half.empty())
      target->lost_px =
          std::clamp(kFarOff * half.back(), kNeverFarOffPx, kLostPx);
  }
  target->lost_px = kLostPx;
  return RmsPx(*fit, *target);
}

}  // namespace

bool IsParametricModel(const std::string& name) {
  return name == "opencv" || name == "thin-prism-fisheye" ||
         name == "central-radial";
}

FittedModel FitParametricModel(const std::string& name,
                               const CameraModel& camera, const Area& area,
                               bool free_rotation) {
  if (const auto* lines = dynamic_cast<const NonCentralGeneric*>(&camera))
    return FitParametricModel(name, lines->CentralPart(), area, free_rotation);
  const Eigen::Quaterniond start_from_camera =
      free_rotation ? LevelFromCamera(camera, area)
                    : Eigen::Quaterniond::Identity();
  Target target;
  target.samples = SampleRays(camera, area);
  for (Sample& sample : target.samples)
    sample.ray = start_from_camera * sample.ray;
  const Center center =
      CenterOf(camera, start_from_camera, area, target.samples);
  FittedModel best;
  double best_cost = INFINITY;
  for (auto& start : Starts(name, camera, center, target.samples)) {
    FittedModel fit;
    fit.model = std::move(start);
    target.decentring_weights.setZero(fit.model->NumParameters());
    const double cost = free_rotation ? RefineWithRotation(area, &target, &fit)
                                      : Refine(target, false, &fit);
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
                            const Area& area) {
  constexpr double kWorthPart = 0.02, kAlwaysCloseEnoughPx = 0.005;
  FittedModel level = FitParametricModel(name, camera, area, false);
  if (level.rms_px <= kAlwaysCloseEnoughPx) return level;
  FittedModel turned = FitParametricModel(name, camera, area, true);
  return turned.rms_px < (1 - kWorthPart) * level.rms_px ? std::move(turned)
                                                         : std::move(level);
}

}  // namespace raygrid
