#include "camera/equivalent_central_camera.h"

#include "simulation/noncentral_simulated_camera.h"
#include "support.h"

namespace raygrid {
namespace {

// A sphere, and a plane that leans.
std::vector<SceneSurface> Surfaces() {
  return {{0.7, std::nullopt},
          {0.7, Eigen::Vector3d(0.2, -0.1, 1).normalized()}};
}

// The point of the surface in a direction.
Eigen::Vector3d PointOn(const SceneSurface& scene,
                        const Eigen::Vector3d& direction) {
  return direction *
         (scene.distance_m /
          (scene.normal ? scene.normal->dot(direction) : direction.norm()));
}

TEST(EquivalentCentralCamera, SeesThePointsThere) {
  const MovingPupilCamera lens(ExampleLens(), 0.02);
  for (const SceneSurface& scene : Surfaces()) {
    const EquivalentCentralCamera camera(lens, scene);
    EXPECT_TRUE(camera.IsCentral());
    TestRandom random(3);
    for (int k = 0; k < 50; ++k) {
      const Eigen::Vector2d pixel = random.PixelIn(lens.area());
      const Eigen::Vector3d ray = *camera.Unproject(pixel);
      EXPECT_NEAR(ray.norm(), 1, 1e-12);
      EXPECT_LT((*lens.Project(PointOn(scene, ray)) - pixel).norm(), 1e-6);
      EXPECT_LT((*camera.Project(3 * ray) - pixel).norm(), 1e-6);
      LinearizedProjection projection;
      ASSERT_TRUE(camera.Linearize(3 * ray, nullptr, 1, &projection));
      const auto project = [&](const Eigen::VectorXd& direction) {
        return *camera.Project(Eigen::Vector3d(direction), nullptr, 1);
      };
      EXPECT_LT((projection.J_point - CentralDifference(project, 3 * ray, 1e-5))
                    .norm(),
                1e-3 * projection.J_point.norm());
    }
  }
}

TEST(EquivalentCentralCamera, SeesNothingThatIsBehindAPlane) {
  const MovingPupilCamera lens(ExampleLens(), 0.02);
  const EquivalentCentralCamera behind(lens, {0.5, Eigen::Vector3d(0, 0, -1)});
  EXPECT_FALSE(behind.Unproject({320, 240}));
  EXPECT_FALSE(behind.Project({0, 0, 1}));
}

}  // namespace
}  // namespace raygrid
