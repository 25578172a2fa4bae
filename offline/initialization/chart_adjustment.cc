#include "initialization/chart_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/LU>
#include <array>
#include <cmath>

namespace raygrid {
namespace {

constexpr int kMaxIterations = 30;
constexpr double kSmoothnessPx = 2;  // standard deviation of second differences
                                     // of control points
constexpr int kNumNodes = 16;

// First-order reprojection error: (ds/dx)^-1 (s(x) - chart(p)). Uses the
// Jacobian of the current surface; with a fixed Jacobian, shrinking the surface
// would reduce the residuals.
struct SurfaceError {
  SplineSupport support;
  Eigen::Vector3d point;

  // Parameter blocks: 16 control points, rotation, translation.
  template <typename T>
  bool operator()(const T* const* blocks, T* error) const {
    const T on_board[3] = {T(point.x()), T(point.y()), T(point.z())};
    T seen[3];
    ceres::AngleAxisRotatePoint(blocks[kNumNodes], on_board, seen);
    for (int k = 0; k < 3; ++k) seen[k] += blocks[kNumNodes + 1][k];
    const T norm =
        sqrt(seen[0] * seen[0] + seen[1] * seen[1] + seen[2] * seen[2]);
    T difference[2], dx[2], dy[2];
    for (int i = 0; i < 2; ++i) {
      difference[i] = -seen[i] / (norm + seen[2]);
      dx[i] = dy[i] = T(0);
      for (int k = 0; k < kNumNodes; ++k) {
        const double wx = support.wx[k % 4], wy = support.wy[k / 4];
        difference[i] += wx * wy * blocks[k][i];
        dx[i] += support.dwx[k % 4] * wy * blocks[k][i];
        dy[i] += wx * support.dwy[k / 4] * blocks[k][i];
      }
    }
    const T determinant = dx[0] * dy[1] - dx[1] * dy[0];
    error[0] = (dy[1] * difference[0] - dy[0] * difference[1]) / determinant;
    error[1] = (dx[0] * difference[1] - dx[1] * difference[0]) / determinant;
    return true;
  }
};

// Second difference of three control points minus its initial value.
struct SmoothnessError {
  Eigen::Vector2d start;
  double weight;

  template <typename T>
  bool operator()(const T* before, const T* node, const T* after,
                  T* error) const {
    for (int k = 0; k < 2; ++k)
      error[k] = weight * (before[k] - 2.0 * node[k] + after[k] - T(start[k]));
    return true;
  }
};

struct PoseBlocks {
  Eigen::Vector3d rotation, translation;
};

void AddObservation(const ChartObservation& observation,
                    BSplineSurface* surface, PoseBlocks* pose,
                    ceres::Problem* problem) {
  const SplineSupport support = surface->Support(observation.pixel);
  auto* cost = new ceres::DynamicAutoDiffCostFunction<SurfaceError, 38>(
      new SurfaceError{support, observation.point});
  std::vector<double*> blocks;
  for (int k = 0; k < kNumNodes; ++k) {
    const int node =
        (support.row + k / 4) * surface->columns() + support.column + k % 4;
    blocks.push_back(surface->points()[node].data());
    cost->AddParameterBlock(2);
  }
  for (Eigen::Vector3d* part : {&pose->rotation, &pose->translation}) {
    blocks.push_back(part->data());
    cost->AddParameterBlock(3);
  }
  cost->SetNumResiduals(2);
  problem->AddResidualBlock(cost, new ceres::HuberLoss(1), blocks);
}

// Returns the typical size of a pixel in chart coordinates.
double ChartPerPixel(const BSplineSurface& surface) {
  Eigen::Matrix2d derivative;
  surface.Evaluate(surface.area().center(), &derivative);
  return std::sqrt(std::abs(derivative.determinant()));
}

void AddSmoothness(BSplineSurface* surface, ceres::Problem* problem) {
  const double weight = 1 / (kSmoothnessPx * ChartPerPixel(*surface));
  std::vector<Eigen::Vector2d>& nodes = surface->points();
  const auto add = [&](int node, int step) {
    problem->AddResidualBlock(
        new ceres::AutoDiffCostFunction<SmoothnessError, 2, 2, 2, 2>(
            new SmoothnessError{
                nodes[node - step] - 2 * nodes[node] + nodes[node + step],
                weight}),
        nullptr, nodes[node - step].data(), nodes[node].data(),
        nodes[node + step].data());
  };
  for (int row = 0; row < surface->rows(); ++row) {
    for (int column = 0; column < surface->columns(); ++column) {
      const int node = row * surface->columns() + column;
      if (column > 0 && column + 1 < surface->columns()) add(node, 1);
      if (row > 0 && row + 1 < surface->rows()) add(node, surface->columns());
    }
  }
}

void Minimize(const std::vector<ChartObservation>& observations,
              BSplineSurface* surface, std::vector<PoseBlocks>* poses) {
  ceres::Problem problem;
  for (const ChartObservation& observation : observations)
    AddObservation(observation, surface, &(*poses)[observation.pose], &problem);
  AddSmoothness(surface, &problem);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = kMaxIterations;
  options.function_tolerance = 1e-4;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
}

}  // namespace

void OptimizeInChart(const std::vector<ChartObservation>& observations,
                     BSplineSurface* surface, std::vector<Pose>* poses) {
  std::vector<PoseBlocks> blocks;
  for (const Pose& pose : *poses) {
    const Eigen::AngleAxisd turn(pose.rotation);
    blocks.push_back({turn.angle() * turn.axis(), pose.translation});
  }
  Minimize(observations, surface, &blocks);
  for (size_t i = 0; i < poses->size(); ++i)
    (*poses)[i] = {RotationFromVector(blocks[i].rotation),
                   blocks[i].translation};
}

}  // namespace raygrid
