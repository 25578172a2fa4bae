// The time that a million calls of a camera take in C++, for array_bench.py.
//   array_bench camera.yaml
// Reads numbers of pixels, x and y by turns, from standard input, as doubles.
// Prints the processor's seconds of project and unproject, each with a result
// of its own: the least of three; then a number that depends on the results.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>
#include <vector>

#include "dataset/camera_file.h"

namespace raygrid {
namespace {

template <typename Body>
double LeastSeconds(const Body& body) {
  std::clock_t least = std::numeric_limits<std::clock_t>::max();
  for (int k = 0; k < 3; ++k) {
    const std::clock_t start = std::clock();
    body();
    least = std::min(least, std::clock() - start);
  }
  return double(least) / CLOCKS_PER_SEC;
}

using Pixels = std::vector<Eigen::Vector2d>;
using Directions = std::vector<Eigen::Vector3d>;

Directions Unproject(const CameraModel& camera, const Pixels& pixels) {
  Directions directions(pixels.size());
  for (size_t k = 0; k < pixels.size(); ++k)
    directions[k] =
        camera.Unproject(pixels[k]).value_or(Eigen::Vector3d(NAN, NAN, NAN));
  return directions;
}

Pixels Project(const CameraModel& camera, const Directions& directions) {
  Pixels pixels(directions.size());
  for (size_t k = 0; k < directions.size(); ++k)
    pixels[k] =
        camera.Project(directions[k]).value_or(Eigen::Vector2d(NAN, NAN));
  return pixels;
}

void Measure(const CameraModel& camera, const Pixels& pixels) {
  const Directions directions = Unproject(camera, pixels);
  double sum = 0;  // of something, so that nothing is left out
  const double project =
      LeastSeconds([&] { sum += Project(camera, directions).back().x(); });
  const double unproject =
      LeastSeconds([&] { sum += Unproject(camera, pixels).back().x(); });
  std::printf("%.6f %.6f %g\n", project, unproject, sum);
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
