// Tables of cameras of lines, for scenes on a surface.
#include <functional>

#include "camera/noncentral_generic.h"
#include "packed_cameras.h"
#include "ramp_images.h"
#include "simulation/noncentral_simulated_camera.h"

namespace raygrid {
namespace {

// A surface, and a point of it in a direction.
struct Scene {
  const char* name;
  SceneSurface surface;
  std::function<Eigen::Vector3d(const Eigen::Vector3d& direction)> point;
};

std::vector<Scene> Scenes() {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, 0.1, 1).normalized();
  return {{"sphere",
           {0.5, std::nullopt},
           [](const Eigen::Vector3d& d) -> Eigen::Vector3d {
             return 0.5 * d.normalized();
           }},
          {"plane",
           {0.5, normal},
           [=](const Eigen::Vector3d& d) -> Eigen::Vector3d {
             return d * (0.5 / normal.dot(d));
           }}};
}

TEST(SceneTables, ShowTheSceneWithinTheBound) {
  const MovingPupilCamera lens(ExampleLens(), 0.02);
  CameraFile file;
  file.camera = std::make_shared<NonCentralGeneric>(
      FitNonCentralGeneric(lens, lens.area(), 24, 18));
  const Image ramps[2] = {RampImage({640, 480}, 0), RampImage({640, 480}, 1)};
  for (const Scene& scene : Scenes()) {
    PackOptions options;
    options.remaps = {ViewOf(*file.camera, {640, 480}, 60)};
    options.remaps[0].scene = scene.surface;
    const PackedCamera packed = PackCamera(file, options);
    const BlobCamera blob("packed", packed.blob);
    const Image shown[2] = {blob.Undistort(ramps[0], 0),
                            blob.Undistort(ramps[1], 0)};
    double worst_px = 0, far_px = 0;
    for (int y = 5; y < 480; y += 12) {
      for (int x = 5; x < 640; x += 12) {
        const auto source = SourceInRamps(shown, x, y);
        if (!source) continue;
        const Eigen::Vector3d direction =
            *options.remaps[0].view.Direction({x, y});
        worst_px = std::max(
            worst_px,
            (*file.camera->Project(scene.point(direction)) - *source).norm());
        far_px = std::max(
            far_px, (*file.camera->Project(1e4 * direction) - *source).norm());
      }
    }
    std::printf("%s: within %.3f px, of what is far away %.2f px (told %.2f)\n",
                scene.name, worst_px, far_px,
                *packed.remaps[0].distant_error_px);
    // Levels add a hundredth of a pixel in x and in y.
    EXPECT_LT(worst_px, 0.05 + 0.015);
    EXPECT_GT(far_px, 1);
    EXPECT_NEAR(far_px, *packed.remaps[0].distant_error_px, 0.1 * far_px);
  }
}

}  // namespace
}  // namespace raygrid
