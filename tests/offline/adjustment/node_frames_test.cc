#include "adjustment/node_frames.h"

#include "camera/stereographic.h"
#include "small_problem.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr int kPerNode = NonCentralGeneric::kPerNode;
constexpr int kFirstOfPoint = NonCentralGeneric::kFirstOfPoint;

TEST(NodeFrames, HaveTheThirdAxisAlongEachLine) {
  SmallProblem problem = MakeSmallProblem({3, 4, 0});
  const CentralGeneric grid = FittedGrid(problem.state.camera(), 80);
  problem.state.SetCamera(NonCentralGeneric(grid));
  const ParameterLayout layout(problem.state, {});
  const NodeFrames frames(layout, problem.state);
  for (int node = 0; node < grid.surface().num_points(); ++node) {
    const int first = layout.first_camera[0] + kPerNode * node + kFirstOfPoint;
    const Eigen::Vector3d line = FromChart(grid.surface().points()[node]);
    Eigen::VectorXd along = Eigen::VectorXd::Zero(layout.size);
    along.segment<3>(first) = line;
    Eigen::VectorXd expected = Eigen::VectorXd::Zero(layout.size);
    expected[first + 2] = 1;
    EXPECT_LT((frames.ToNodeFrames(along) - expected).norm(), 1e-12) << node;
  }
}

TEST(NodeFrames, AreLeftAsTheyAreEntered) {
  SmallProblem problem = MakeSmallProblem({3, 4, 0});
  for (const bool has_lines : {false, true}) {
    const CentralGeneric grid = FittedGrid(problem.state.camera(), 80);
    if (has_lines)
      problem.state.SetCamera(NonCentralGeneric(grid));
    else
      problem.state.SetCamera(grid);
    const ParameterLayout layout(problem.state, {});
    const NodeFrames frames(layout, problem.state);
    const Eigen::VectorXd vector =
        Eigen::VectorXd::LinSpaced(layout.size, -1, 1);
    const Eigen::VectorXd inside = frames.ToNodeFrames(vector);
    EXPECT_EQ((inside - vector).norm() > 0, has_lines);
    EXPECT_LT((frames.FromNodeFrames(inside) - vector).norm(), 1e-12);
    Eigen::SparseMatrix<double> form(layout.size, layout.size);
    for (int i = 0; i < layout.size; ++i) form.insert(i, i) = 1 + i % 7;
    EXPECT_NEAR(inside.dot(frames.TransformNodes(form) * inside),
                vector.dot(form * vector), 1e-9);
  }
}

}  // namespace
}  // namespace raygrid
