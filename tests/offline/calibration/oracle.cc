#include "oracle.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace raygrid {
namespace {

// Displacements of the image by what is unknown of a lens: those of the nodes
// of a B-spline lattice, and of the parameters of its lens without bumps.
class Displacements {
 public:
  // By the unknowns with these indices, a column each.
  struct Derivative {
    std::vector<int> index;
    Eigen::Matrix2Xd value;
  };

  explicit Displacements(const LensFamily& family)
      : size_(family.size),
        cell_px_(family.num_bumps > 0 ? family.radius_px / 2
                                      : family.size.width / 8.0),
        columns_(NumNodesAlong(family.size.width)),
        rows_(NumNodesAlong(family.size.height)) {}

  int num_nodes() const { return columns_ * rows_; }
  int num_unknowns() const { return 2 * num_nodes() + kNumLens; }

  Eigen::Vector2d GetPixel(int node) const {
    return cell_px_ * Eigen::Vector2d(node % columns_ - 1, node / columns_ - 1);
  }

  Derivative At(const Eigen::Vector2d& pixel) const {
    Derivative derivative;
    derivative.value.resize(2, 32 + kNumLens);
    const auto add = [&](int index, const Eigen::Vector2d& value) {
      derivative.value.col(static_cast<int>(derivative.index.size())) = value;
      derivative.index.push_back(index);
    };
    const Eigen::Vector2d place = pixel / cell_px_;
    const int column = std::clamp(static_cast<int>(place.x()), 0, columns_ - 4);
    const int row = std::clamp(static_cast<int>(place.y()), 0, rows_ - 4);
    const Eigen::Vector4d wx = CubicWeights(place.x() - column),
                          wy = CubicWeights(place.y() - row);
    for (int k = 0; k < 32; ++k)
      add(2 * ((row + k / 8) * columns_ + column + k / 2 % 4) + k % 2,
          wx[k / 2 % 4] * wy[k / 8] * Eigen::Vector2d::Unit(k % 2));
    const Eigen::Vector2d extent(size_.width, size_.height);
    const Eigen::Vector2d p = (pixel - extent / 2) * 2 / extent.norm();
    const double x = p.x(), y = p.y(), r2 = p.squaredNorm();
    Eigen::Matrix<double, 2, kNumLens> lens;
    lens << x, 0, 1, 0, r2 * x, r2 * r2 * x, r2 * r2 * r2 * x, 2 * x * y,
        r2 + 2 * x * x,  //
        0, y, 0, 1, r2 * y, r2 * r2 * y, r2 * r2 * r2 * y, r2 + 2 * y * y,
        2 * x * y;
    for (int k = 0; k < kNumLens; ++k) add(2 * num_nodes() + k, lens.col(k));
    return derivative;
  }

 private:
  static constexpr int kNumLens = 9;

  int NumNodesAlong(int extent) const {
    return static_cast<int>(std::ceil((extent - 1) / cell_px_)) + 3;
  }
  // The weights of the uniform cubic B-splines around a cell.
  static Eigen::Vector4d CubicWeights(double t) {
    const double t2 = t * t, t3 = t2 * t;
    return Eigen::Vector4d(1 - 3 * t + 3 * t2 - t3, 4 - 6 * t2 + 3 * t3,
                           1 + 3 * t + 3 * t2 - 3 * t3, t3) /
           6;
  }

  ImageSize size_;
  double cell_px_;
  int columns_, rows_;
};

// The covariance of a coordinate of the displacements at two pixels: a mean
// over the bumps' centres.
double Covariance(const LensFamily& family, const Eigen::Vector2d& a,
                  const Eigen::Vector2d& b) {
  const double r = family.radius_px;
  const auto mean = [r](double middle, double extent) {
    const double first = -2 * r, last = extent - 1 + 2 * r;
    return r * std::sqrt(M_PI) / 2 *
           (std::erf((last - middle) / r) - std::erf((first - middle) / r)) /
           (last - first);
  };
  const Eigen::Vector2d middle = (a + b) / 2;
  return family.num_bumps * family.bump_px * family.bump_px *
         std::exp(-(a - b).squaredNorm() / (4 * r * r)) *
         mean(middle.x(), family.size.width) *
         mean(middle.y(), family.size.height);
}

Eigen::MatrixXd PriorPrecision(const LensFamily& family,
                               const Displacements& displacements) {
  constexpr double kLeast = 1e-8;  // variance, px^2
  const int n = displacements.num_nodes();
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  for (int a = 0; a < n && family.num_bumps > 0; ++a)
    for (int b = 0; b < n; ++b)
      covariance(a, b) = Covariance(family, displacements.GetPixel(a),
                                    displacements.GetPixel(b));
  covariance.diagonal().array() += kLeast;
  return covariance.llt().solve(Eigen::MatrixXd::Identity(n, n));
}

// d point / d an update of its pose (UpdatedPose()).
Eigen::Matrix<double, 3, 6> PoseJacobian(const Eigen::Vector3d& point) {
  Eigen::Matrix<double, 3, 6> J_pose;
  J_pose << 0, point.z(), -point.y(), 1, 0, 0,  //
      -point.z(), 0, point.x(), 0, 1, 0,        //
      point.y(), -point.x(), 0, 0, 0, 1;
  return J_pose;
}

// The Hessian of the unknowns, poses eliminated.
Eigen::MatrixXd Hessian(const Displacements& displacements,
                        const CameraModel& truth,
                        const SimulatedObservations& simulated,
                        double noise_px) {
  std::map<std::string, Pose> poses;
  for (const BoardPose& pose : simulated.poses)
    poses[pose.image] = pose.camera_from_board;
  const Board& board = simulated.true_pattern.boards[0];
  const int size = displacements.num_unknowns();
  Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(size, size);
  for (const ImageFeatures& image : simulated.dataset.images) {
    Eigen::Matrix<double, 6, 6> of_pose = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::MatrixXd with_pose = Eigen::MatrixXd::Zero(size, 6);
    for (const Feature& feature : image.features) {
      const Eigen::Vector3d point =
          poses.at(image.image) *
          board.points[feature.row * board.columns + feature.column];
      LinearizedProjection projection;
      if (!truth.Linearize(point, &feature.pixel, 1, &projection)) continue;
      const Eigen::Matrix<double, 2, 6> J_pose =
          projection.J_point * PoseJacobian(point) / noise_px;
      const Displacements::Derivative moved = displacements.At(feature.pixel);
      of_pose += J_pose.transpose() * J_pose;
      for (size_t a = 0; a < moved.index.size(); ++a) {
        const Eigen::Vector2d by_a =
            moved.value.col(static_cast<int>(a)) / noise_px;
        with_pose.row(moved.index[a]) += by_a.transpose() * J_pose;
        for (size_t b = 0; b < moved.index.size(); ++b)
          hessian(moved.index[a], moved.index[b]) +=
              by_a.dot(moved.value.col(static_cast<int>(b))) / noise_px;
      }
    }
    hessian -= with_pose * of_pose.llt().solve(with_pose.transpose());
  }
  return hessian;
}

}  // namespace

double OracleRmsPx(const LensFamily& family, const CameraModel& truth,
                   const SimulatedObservations& simulated, double noise_px) {
  constexpr double kStepPx = 20, kFree = 1e-10;
  const Displacements displacements(family);
  Eigen::MatrixXd hessian = Hessian(displacements, truth, simulated, noise_px);
  const Eigen::MatrixXd prior = PriorPrecision(family, displacements);
  for (int a = 0; a < displacements.num_nodes(); ++a)
    for (int b = 0; b < displacements.num_nodes(); ++b)
      for (int k = 0; k < 2; ++k) hessian(2 * a + k, 2 * b + k) += prior(a, b);
  hessian.diagonal().array() += kFree;

  std::vector<Displacements::Derivative> moved;
  std::vector<Eigen::Matrix<double, 2, 3>> turned;
  for (double y = 0; y < family.size.height; y += kStepPx)
    for (double x = 0; x < family.size.width; x += kStepPx) {
      const Eigen::Vector2d pixel(x, y);
      const auto ray = truth.Unproject(pixel);
      LinearizedProjection projection;
      if (!ray || !truth.Linearize(*ray, &pixel, 1, &projection)) continue;
      moved.push_back(displacements.At(pixel));
      turned.push_back(projection.J_point * PoseJacobian(*ray).leftCols<3>());
    }
  const auto count = static_cast<Eigen::Index>(moved.size());
  Eigen::MatrixXd by_unknown =
      Eigen::MatrixXd::Zero(2 * count, displacements.num_unknowns());
  Eigen::MatrixXd by_turn(2 * count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (size_t k = 0; k < moved[i].index.size(); ++k)
      by_unknown.block<2, 1>(2 * i, moved[i].index[k]) +=
          moved[i].value.col(static_cast<int>(k));
    by_turn.middleRows<2>(2 * i) = turned[i];
  }
  // No observation sees the camera's rotation.
  by_unknown -= by_turn * (by_turn.transpose() * by_turn)
                              .llt()
                              .solve(by_turn.transpose() * by_unknown);
  const Eigen::MatrixXd root =
      hessian.llt().matrixL().solve(by_unknown.transpose());
  return std::sqrt(root.squaredNorm() / static_cast<double>(count));
}

}  // namespace raygrid
