/// Reprojection errors for Ceres: with a calibrated camera, and with intrinsics
/// that are optimized, too. Reads a camera.yaml, simulates views of points, and
/// finds the poses again.
///   ceres_reprojection camera.yaml
#include <ceres/ceres.h>
#include <raygrid_host/camera.h>

#include <cstdio>
#include <memory>
#include <random>
#include <vector>

namespace {

using raygrid::CameraD;
using RowMajor23 = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;
using RowMajor24 = Eigen::Matrix<double, 2, 4, Eigen::RowMajor>;
using RowMajor2X = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;
constexpr double kUnseenPx = 1e3;  // residual of points that are not visible

// d (q point) / d (x, y, z, w) of a unit quaternion.
Eigen::Matrix<double, 3, 4> RotationJacobian(const Eigen::Quaterniond& q,
                                             const Eigen::Vector3d& point) {
  const Eigen::Vector3d v = q.vec();
  Eigen::Matrix3d cross;
  cross << 0, -point.z(), point.y(), point.z(), 0, -point.x(), -point.y(),
      point.x(), 0;
  Eigen::Matrix<double, 3, 4> J;
  J.leftCols<3>() = -2 * q.w() * cross +
                    2 * (v.dot(point) * Eigen::Matrix3d::Identity() +
                         v * point.transpose() - 2 * point * v.transpose());
  J.col(3) = 2 * v.cross(point);
  return J;
}

// Residual of one point. Blocks: rotation (x, y, z, w) and translation of
// camera_from_world; with free intrinsics also Camera::Parameters().
class ReprojectionError : public ceres::CostFunction {
 public:
  ReprojectionError(std::shared_ptr<const CameraD> camera, bool is_free,
                    const Eigen::Vector3d& point, const Eigen::Vector2d& pixel)
      : camera_(std::move(camera)), point_(point), pixel_(pixel) {
    set_num_residuals(2);
    *mutable_parameter_block_sizes() = {4, 3};
    if (is_free)
      mutable_parameter_block_sizes()->push_back(camera_->NumParameters());
  }

  bool Evaluate(double const* const* blocks, double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Eigen::Quaterniond> rotation(blocks[0]);
    const Eigen::Map<const Eigen::Vector3d> translation(blocks[1]);
    const Eigen::Vector3d seen = rotation * point_ + translation;
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> J_point;
    raygrid::IntrinsicsJacobian<double> J_intrinsics;
    const bool is_free = parameter_block_sizes().size() == 3;
    const bool is_seen =
        camera_->Project(seen, &pixel, jacobians ? &J_point : nullptr,
                         jacobians && is_free ? &J_intrinsics : nullptr);
    if (!is_seen) {
      pixel = pixel_ + Eigen::Vector2d::Constant(kUnseenPx);
      J_point.setZero();
    }
    Eigen::Map<Eigen::Vector2d>{residuals} = pixel - pixel_;
    if (!jacobians) return true;
    if (jacobians[0])
      Eigen::Map<RowMajor24>{jacobians[0]} =
          J_point * RotationJacobian(rotation, point_);
    if (jacobians[1]) Eigen::Map<RowMajor23>{jacobians[1]} = J_point;
    if (is_free && jacobians[2]) {
      Eigen::Map<RowMajor2X> J(jacobians[2], 2, camera_->NumParameters());
      J.setZero();
      if (is_seen) J_intrinsics.AddTo(&J);
    }
    return true;
  }

 private:
  std::shared_ptr<const CameraD> camera_;
  Eigen::Vector3d point_;
  Eigen::Vector2d pixel_;
};

// Ceres calls it before residuals are evaluated at other intrinsics.
class UpdateIntrinsics : public ceres::EvaluationCallback {
 public:
  UpdateIntrinsics(std::shared_ptr<CameraD> camera,
                   const Eigen::VectorXd* parameters)
      : camera_(std::move(camera)), parameters_(parameters) {}
  void PrepareForEvaluation(bool, bool is_new_point) override {
    if (is_new_point) camera_->SetParameters(*parameters_);
  }

 private:
  std::shared_ptr<CameraD> camera_;
  const Eigen::VectorXd* parameters_;
};

struct View {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

struct Observation {
  size_t view;
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;
};

// Points of the world that the views see.
std::vector<Observation> Simulate(const CameraD& camera,
                                  const std::vector<View>& views) {
  std::mt19937 random(1);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * random() / 4294967296.0;
  };
  std::vector<Observation> observations;
  const auto bounds = camera.Bounds();
  for (size_t k = 0; k < views.size(); ++k) {
    for (int i = 0; i < 150; ++i) {
      const Eigen::Vector2d pixel(uniform(bounds.min().x(), bounds.max().x()),
                                  uniform(bounds.min().y(), bounds.max().y()));
      Eigen::Vector3d origin, bearing;
      if (!camera.UnprojectLine(pixel, &origin, &bearing)) continue;
      const Eigen::Vector3d seen = origin + uniform(1, 4) * bearing;
      observations.push_back(
          {k, views[k].rotation.conjugate() * (seen - views[k].translation),
           pixel});
    }
  }
  return observations;
}

// Finds the poses, and with `intrinsics` also these. Returns the RMS error in
// pixels.
double Optimize(const std::shared_ptr<CameraD>& camera,
                const std::vector<Observation>& observations,
                std::vector<View>* views, Eigen::VectorXd* intrinsics) {
  UpdateIntrinsics update(camera, intrinsics);
  ceres::Problem::Options problem_options;
  if (intrinsics) problem_options.evaluation_callback = &update;
  ceres::Problem problem(problem_options);
  for (const Observation& seen : observations) {
    View& view = (*views)[seen.view];
    std::vector<double*> blocks = {view.rotation.coeffs().data(),
                                   view.translation.data()};
    if (intrinsics) blocks.push_back(intrinsics->data());
    problem.AddResidualBlock(
        new ReprojectionError(camera, intrinsics != nullptr, seen.point,
                              seen.pixel),
        new ceres::HuberLoss(1), blocks);
  }
  for (View& view : *views)
    problem.SetManifold(view.rotation.coeffs().data(),
                        new ceres::EigenQuaternionManifold);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 30;
  options.function_tolerance = 1e-14;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return std::sqrt(2 * summary.final_cost /
                   static_cast<double>(observations.size()));
}

}  // namespace

int main(int argc, char** argv) {
  std::string error = "usage: ceres_reprojection camera.yaml";
  const auto loaded = argc == 2 ? CameraD::Load(argv[1], &error) : std::nullopt;
  if (!loaded) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return 1;
  }
  std::vector<View> truth(3);
  for (int k = 0; k < 3; ++k) {
    truth[k].rotation = Eigen::AngleAxisd(
        0.2 * k, Eigen::Vector3d(1, k - 1.0, 0.5).normalized());
    truth[k].translation << 0.3 * k, -0.1, 0.2;
  }
  const auto observations = Simulate(*loaded, truth);
  std::vector<View> views = truth;
  for (View& view : views) {
    view.rotation =
        view.rotation * Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY());
    view.translation += Eigen::Vector3d(0.02, -0.01, 0.01);
  }
  const std::vector<View> starts = views;

  auto camera = std::make_shared<CameraD>(*loaded);
  const double fixed_px = Optimize(camera, observations, &views, nullptr);
  std::printf("fixed intrinsics: RMS error %.1e px\n", fixed_px);

  views = starts;
  Eigen::VectorXd intrinsics = loaded->Parameters() * 1.002;
  const double free_px = Optimize(camera, observations, &views, &intrinsics);
  std::printf("free intrinsics: RMS error %.1e px\n", free_px);
  return fixed_px < 1e-6 && free_px < 1e-3 ? 0 : 1;
}
