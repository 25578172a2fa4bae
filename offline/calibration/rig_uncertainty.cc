#include "calibration/rig_uncertainty.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "adjustment/group_jackknife.h"
#include "calibration/rig_initialization.h"

namespace raygrid {
namespace {

Eigen::Matrix3d CrossProductMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0, -v.z(), v.y(),  //
      v.z(), 0, -v.x(),        //
      -v.y(), v.x(), 0;
  return matrix;
}

// Jacobian of the update of second_from_first, six rows, with respect to the
// updates of the poses of all cameras but the first. With R and t of
// second_from_first, F and S: dw = w_S - R w_F and dt = t_S - R t_F + [R p]x dw
// for the translation p of F.
Eigen::MatrixXd ComputeJacobianOfRelativePose(
    const std::vector<Pose>& camera_from_rig, const Baseline& baseline) {
  const Pose& first = camera_from_rig[baseline.first];
  const Eigen::Matrix3d R =
      (camera_from_rig[baseline.second].rotation * first.rotation.conjugate())
          .toRotationMatrix();
  const Eigen::Matrix3d lever = CrossProductMatrix(R * first.translation);
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(
      6, 6 * (static_cast<Eigen::Index>(camera_from_rig.size()) - 1));
  if (baseline.first > 0) {
    auto J_first_pose = jacobian.middleCols<6>(
        6 * static_cast<Eigen::Index>(baseline.first - 1));
    J_first_pose << -R, Eigen::Matrix3d::Zero(), -lever * R, -R;
  }
  if (baseline.second > 0) {
    auto J_second_pose = jacobian.middleCols<6>(
        6 * static_cast<Eigen::Index>(baseline.second - 1));
    J_second_pose << Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero(),
        lever, Eigen::Matrix3d::Identity();
  }
  return jacobian;
}

// Unit vectors by which a relative pose is scaled to the jackknife: the axes
// for the rotation; along the baseline and across it for the translation.
Eigen::Matrix<double, 6, 6> ListScaledDirections(
    const Eigen::Vector3d& baseline) {
  Eigen::Matrix<double, 6, 6> directions =
      Eigen::Matrix<double, 6, 6>::Identity();
  if (!(baseline.norm() > 0)) return directions;
  const Eigen::Vector3d along = baseline.normalized();
  const Eigen::Vector3d across = along.unitOrthogonal();
  directions.bottomRightCorner<3, 3>() << along, across, along.cross(across);
  return directions;
}

// Square roots of the variance factors of the directions.
Eigen::Matrix<double, 6, 1> ComputeScales(
    const GroupJackknife& jackknife, int first_parameter,
    const Eigen::MatrixXd& by_parameters) {
  Eigen::Matrix<double, 6, 1> scales = Eigen::Matrix<double, 6, 1>::Ones();
  if (!jackknife.IsValid()) return scales;
  const auto scale_of = [&](int row, int count) {
    return std::sqrt(
        VarianceFactors(
            jackknife.Of(first_parameter, by_parameters.middleRows(row, count)))
            .overall_factor);
  };
  for (int row = 0; row < 4; ++row) scales[row] = scale_of(row, 1);
  scales.tail<2>().setConstant(scale_of(4, 2));
  return scales;
}

// Makes a matrix symmetric and removes negative eigenvalues of its correlation:
// solutions of large equations are not exact.
PoseCovariance MakeCovariance(const PoseCovariance& matrix) {
  const PoseCovariance symmetric = (matrix + matrix.transpose()) / 2;
  const Eigen::Matrix<double, 6, 1> deviations =
      symmetric.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const PoseCovariance correlation = deviations.cwiseInverse().asDiagonal() *
                                     symmetric *
                                     deviations.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<PoseCovariance> solver(correlation);
  if (solver.eigenvalues()[0] >= 0) return symmetric;
  const PoseCovariance root = deviations.asDiagonal() * solver.eigenvectors();
  return root * solver.eigenvalues().cwiseMax(0).asDiagonal() *
         root.transpose();
}

// Adds the covariances of the relative poses, and the standard deviations that
// follow from them; leaves them empty if the equations are singular.
void AddCovariances(const AdjustmentResult& adjusted, AdjustmentOptions options,
                    std::vector<Baseline>* baselines) {
  options.fix_points = !HavePointsMoved(adjusted);
  const std::vector<Pose>& camera_from_rig = adjusted.state.camera_from_rig;
  const LinearResponse response(adjusted.problem.views, adjusted.prior, options,
                                adjusted.state);
  const int first = response.layout().CameraPose(1);
  const auto count =
      6 * (static_cast<Eigen::Index>(camera_from_rig.size()) - 1);
  Eigen::MatrixXd right =
                      Eigen::MatrixXd::Zero(response.layout().num_all(), count),
                  x;
  right.middleRows(first, count).setIdentity();
  if (!response.Solve(right, &x)) return;
  const double noise_px = adjusted.summary.noise_px;
  const Eigen::MatrixXd white =
      noise_px * noise_px * x.middleRows(first, count);
  const GroupJackknife jackknife(response, adjusted.problem.views,
                                 adjusted.prior, options, adjusted.state,
                                 noise_px);
  for (Baseline& baseline : *baselines) {
    const Pose relative = camera_from_rig[baseline.second] *
                          camera_from_rig[baseline.first].Inverse();
    const auto directions = ListScaledDirections(relative.translation);
    const Eigen::MatrixXd jacobian =
        directions.transpose() *
        ComputeJacobianOfRelativePose(camera_from_rig, baseline);
    const auto scales = ComputeScales(jackknife, first, jacobian);
    const PoseCovariance scaled =
        scales.asDiagonal() *
        PoseCovariance(jacobian * white * jacobian.transpose()) *
        scales.asDiagonal();
    baseline.distance_stddev_m = std::sqrt(scaled(3, 3));
    baseline.rotation_stddev_rad =
        std::sqrt(scaled.topLeftCorner<3, 3>().trace());
    if (scaled.allFinite())
      baseline.covariance =
          MakeCovariance(directions * scaled * directions.transpose());
  }
}

}  // namespace

std::vector<Baseline> EstimateBaselines(const AdjustmentResult& adjusted,
                                        const AdjustmentOptions& options) {
  std::vector<Baseline> baselines =
      ComputeBaselines(adjusted.state.camera_from_rig);
  if (baselines.empty()) return baselines;
  const auto num_shared = CountSharedViews(adjusted.problem);
  for (Baseline& baseline : baselines)
    baseline.num_shared_views = num_shared[baseline.first][baseline.second];
  AddCovariances(adjusted, options, &baselines);
  return baselines;
}

}  // namespace raygrid
