/// Reads a camera.yaml, simulates an image of points of which a third is
/// mismatched, and finds the pose of the camera by pose_from_points.h.
///   pose_from_points camera.yaml
#include "pose_from_points.h"

#include <raygrid_host/camera.h>

#include <cstdio>

int main(int argc, char** argv) {
  std::string error = "usage: pose_from_points camera.yaml";
  const auto camera =
      argc == 2 ? raygrid::CameraD::Load(argv[1], &error) : std::nullopt;
  if (!camera) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return 1;
  }
  std::mt19937 random(7);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * random() / 4294967296.0;
  };
  const Eigen::Isometry3d truth =
      Eigen::Translation3d(0.4, -0.2, 0.1) *
      Eigen::AngleAxisd(0.6, Eigen::Vector3d(1, 2, -1).normalized());
  std::vector<examples::LineObservation> observations;
  const auto bounds = camera->Bounds();
  for (int i = 0; i < 90; ++i) {
    const Eigen::Vector2d pixel(uniform(bounds.min().x(), bounds.max().x()),
                                uniform(bounds.min().y(), bounds.max().y()));
    examples::LineObservation seen;
    if (!camera->UnprojectLine(pixel, &seen.origin, &seen.bearing)) continue;
    seen.point = truth.inverse() * (seen.origin + uniform(1, 4) * seen.bearing);
    if (i % 3 == 0) seen.point += Eigen::Vector3d(uniform(0.3, 1), 0.4, -0.5);
    observations.push_back(seen);
  }
  const auto pose = examples::EstimatePose(observations, 0.01);
  if (!pose) return 1;
  const double turned =
      Eigen::AngleAxisd(pose->linear().transpose() * truth.linear()).angle();
  const double moved = (pose->translation() - truth.translation()).norm();
  std::printf("errors of the pose: %.1e rad, %.1e m\n", turned, moved);
  return turned < 1e-9 && moved < 1e-9 ? 0 : 1;
}
