// The time that a million calls of a camera take in C++, for array_bench.py.
//   array_bench camera.yaml
// Reads numbers of pixels, x and y by turns, from standard input, as doubles.
// Prints the seconds of project and unproject: the least of three.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

#include "dataset/camera_file.h"

namespace raygrid {
namespace {

template <typename Body>
double LeastSeconds(const Body& body) {
  using Clock = std::chrono::steady_clock;
  double least = INFINITY;
  for (int k = 0; k < 3; ++k) {
    const auto start = Clock::now();
    body();
    least = std::min(
        least, std::chrono::duration<double>(Clock::now() - start).count());
  }
  return least;
}

void Measure(const CameraModel& camera,
             const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<Eigen::Vector3d> directions(pixels.size());
  std::vector<Eigen::Vector2d> seen(pixels.size());
  const double unproject = LeastSeconds([&] {
    for (size_t k = 0; k < pixels.size(); ++k) {
      const auto direction = camera.Unproject(pixels[k]);
      directions[k] = direction.value_or(Eigen::Vector3d(NAN, NAN, NAN));
    }
  });
  const double project = LeastSeconds([&] {
    for (size_t k = 0; k < pixels.size(); ++k) {
      const auto pixel = camera.Project(directions[k]);
      seen[k] = pixel.value_or(Eigen::Vector2d(NAN, NAN));
    }
  });
  std::printf("%.6f %.6f\n", project, unproject);
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  if (argc != 2) return 1;
  std::vector<Eigen::Vector2d> pixels;
  for (double pixel[2]; std::fread(pixel, sizeof pixel, 1, stdin) == 1;)
    pixels.emplace_back(pixel[0], pixel[1]);
  raygrid::Measure(*raygrid::ReadCameraFile(argv[1]).camera, pixels);
}
