#include "camera/model_fitting.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "camera/central_radial.h"
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

// Where the camera looks straight ahead, and its focal length there; as far as
// it does, or else from the samples' spread.
struct Center {
  Eigen::Vector2d pixel;
  double focal_px;
};

Center CenterOf(const CameraModel& camera, const Area& area,
                const std::vector<Sample>& samples) {
  LinearizedProjection linear;
  if (camera.Linearize({0, 0, 1}, nullptr, 0, &linear))
    return {linear.pixel,
            std::sqrt(std::abs(linear.by_point.leftCols<2>().determinant()))};
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

// The least-squares problem; the rotation's update comes last.
struct Equations {
  double cost = 0;
  Eigen::MatrixXd normal;
  Eigen::VectorXd gradient;
};

double CostOf(const ParametricModel& model, const Eigen::Quaterniond& rotation,
              const std::vector<Sample>& samples) {
  double cost = 0;
  for (const Sample& sample : samples) {
    const auto pixel =
        model.Project(rotation * sample.ray, nullptr, kAnywherePx);
    cost += pixel ? std::min((*pixel - sample.pixel).squaredNorm(),
                             kLostPx * kLostPx)
                  : kLostPx * kLostPx;
  }
  return cost;
}

// What keeps parameters of no effect, as a spline's beyond the samples, smooth
// and small.
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

Equations Linearize(const ParametricModel& model,
                    const Eigen::Quaterniond& rotation,
                    const std::vector<Sample>& samples) {
  const int num_parameters = model.NumParameters(), size = num_parameters + 3;
  Equations equations;
  equations.normal.setZero(size, size);
  equations.gradient.setZero(size);
  for (const Sample& sample : samples) {
    const Eigen::Vector3d ray = rotation * sample.ray;
    LinearizedProjection linear;
    if (!model.Linearize(ray, nullptr, kAnywherePx, &linear)) continue;
    const Eigen::Vector2d error = linear.pixel - sample.pixel;
    if (error.norm() > kLostPx) continue;
    Eigen::MatrixXd row = Eigen::MatrixXd::Zero(2, size);
    for (int k = 0; k < linear.num_nodes; ++k)
      row.col(linear.node_parameter[k]) +=
          linear.node_weight[k] * linear.by_node.col(0);
    row.middleCols(linear.first_global, linear.num_global) =
        linear.by_global.leftCols(linear.num_global);
    for (int k = 0; k < 3; ++k)
      row.col(num_parameters + k) =
          linear.by_point * Eigen::Vector3d::Unit(k).cross(ray);
    equations.normal += row.transpose() * row;
    equations.gradient += row.transpose() * error;
  }
  AddRidge(model, &equations);
  return equations;
}

// Levenberg-Marquardt. Returns the cost.
double Refine(const std::vector<Sample>& samples, bool free_rotation,
              FittedModel* fit) {
  constexpr int kMaxIterations = 100;
  constexpr double kConverged = 1e-10;
  ParametricModel& model = *fit->model;
  double cost = CostOf(model, fit->model_from_camera, samples), lambda = 1e-4;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Equations equations =
        Linearize(model, fit->model_from_camera, samples);
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
      const double next_cost = CostOf(
          dynamic_cast<const ParametricModel&>(*next), rotation, samples);
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

}  // namespace

bool IsParametricModel(const std::string& name) {
  return name == "opencv" || name == "thin-prism-fisheye" ||
         name == "central-radial";
}

FittedModel FitParametricModel(const std::string& name,
                               const CameraModel& camera, const Area& area,
                               bool free_rotation) {
  const std::vector<Sample> samples = SampleRays(camera, area);
  const Center center = CenterOf(camera, area, samples);
  FittedModel best;
  double best_cost = INFINITY;
  for (auto& start : Starts(name, camera, center, samples)) {
    FittedModel fit;
    fit.model = std::move(start);
    const double cost = Refine(samples, free_rotation, &fit);
    if (best.model && !(cost < best_cost)) continue;
    best = std::move(fit);
    best_cost = cost;
  }
  return best;
}

}  // namespace raygrid
