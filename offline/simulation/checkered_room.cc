#include "simulation/checkered_room.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "dataset/parallel_for.h"
#include "simulation/image_rendering.h"

namespace raygrid {
namespace {

// Number of samples per pixel along each axis.
constexpr int kSamples = 4;
// Colours of the light squares, BGR: front and back, left and right, ceiling
// and floor.
constexpr std::array<std::array<float, 3>, 6> kWalls = {{{232, 228, 226},
                                                         {222, 190, 214},
                                                         {226, 206, 176},
                                                         {186, 218, 184},
                                                         {196, 226, 238},
                                                         {168, 192, 220}}};
constexpr float kDarkFactor = 0.52f;

// A checkerboard square on one of the walls of the room.
struct SceneSquare {
  int wall;
  int column, row;

  bool operator==(const SceneSquare& other) const {
    return wall == other.wall && column == other.column && row == other.row;
  }
};

SceneSquare FindSquareOnRay(const Eigen::Vector3d& direction, double square) {
  int axis = 0;
  const double reach = direction.cwiseAbs().maxCoeff(&axis);
  const int pair = axis == 2 ? 0 : axis == 0 ? 1 : 2;
  const bool is_second = axis == 1 ? direction[axis] > 0 : direction[axis] < 0;
  const double unit = reach * square;
  return {2 * pair + is_second,
          static_cast<int>(std::floor(direction[(axis + 1) % 3] / unit)),
          static_cast<int>(std::floor(direction[(axis + 2) % 3] / unit))};
}

void AddColor(const SceneSquare& square, float weight,
              std::array<float, 3>* sum) {
  if (((square.column + square.row) & 1) != 0) weight *= kDarkFactor;
  for (int c = 0; c < 3; ++c) (*sum)[c] += weight * kWalls[square.wall][c];
}

// Returns the mean colour of a pixel from the directions of its corners.
// Squares are convex: if all corners are in one square, so is the pixel.
std::array<float, 3> MeanColor(const Eigen::Vector3d (&corners)[4],
                               double square) {
  std::array<float, 3> sum = {};
  const SceneSquare first = FindSquareOnRay(corners[0], square);
  if (first == FindSquareOnRay(corners[1], square) &&
      first == FindSquareOnRay(corners[2], square) &&
      first == FindSquareOnRay(corners[3], square)) {
    AddColor(first, 1, &sum);
    return sum;
  }
  constexpr float kWeight = 1.0f / (kSamples * kSamples);
  for (int j = 0; j < kSamples; ++j) {
    const double v = (j + 0.5) / kSamples;
    const Eigen::Vector3d left = (1 - v) * corners[0] + v * corners[2];
    const Eigen::Vector3d right = (1 - v) * corners[1] + v * corners[3];
    for (int i = 0; i < kSamples; ++i) {
      const double u = (i + 0.5) / kSamples;
      AddColor(FindSquareOnRay((1 - u) * left + u * right, square), kWeight,
               &sum);
    }
  }
  return sum;
}

}  // namespace

double ComputeVisibleAngleDeg(const CameraModel& camera, int axis) {
  const Area& area = camera.area();
  const auto center = camera.Unproject(area.center());
  if (!center) return 0;
  const double low = axis == 0 ? area.x0 : area.y0;
  const double high = axis == 0 ? area.x1 : area.y1;
  double sum_rad = 0;
  for (const double edge : {low, high}) {
    // The last valid direction before the edge; for fisheye lenses, at the rim
    // of the image circle.
    constexpr int kSteps = 256;
    for (int k = kSteps; k > 0; --k) {
      Eigen::Vector2d pixel = area.center();
      pixel[axis] += (edge - pixel[axis]) * k / kSteps;
      const auto ray = camera.Unproject(pixel);
      if (!ray) continue;
      sum_rad += std::atan2(ray->cross(*center).norm(), ray->dot(*center));
      break;
    }
  }
  return sum_rad * 180 / M_PI;
}

double ComputeSceneSquareSize(const CameraModel& camera) {
  constexpr double kAcross = 12;
  const double field_rad = ComputeVisibleAngleDeg(camera, 0) * M_PI / 180;
  const double square = std::exp2(std::round(std::log2(field_rad / kAcross)));
  return std::clamp(square, 1.0 / 1024, 0.25);
}

Image RenderCheckeredRoom(const CameraModel& camera, double square,
                          uint8_t not_calibrated, int num_threads) {
  const PixelRays rays(camera, num_threads);
  Image image;
  image.size = camera.image_size();
  image.channels = 3;
  image.pixels.assign(image.stride() * image.size.height, not_calibrated);
  constexpr int kBand = 16;
  const int num_bands = (image.size.height + kBand - 1) / kBand;
  ParallelFor(num_bands, NumThreads(num_threads), [&](int band) {
    const int first = band * kBand;
    const int last = std::min(first + kBand, image.size.height);
    const auto rows = rays.Rows(first, last);
    for (int y = first; y < last; ++y) {
      for (int x = 0; x < image.size.width; ++x) {
        const Eigen::Vector3d corners[4] = {
            rows->Line(x, y).direction, rows->Line(x + 1, y).direction,
            rows->Line(x, y + 1).direction, rows->Line(x + 1, y + 1).direction};
        if (!(corners[0] + corners[1] + corners[2] + corners[3]).allFinite())
          continue;
        const auto color = MeanColor(corners, square);
        for (int c = 0; c < 3; ++c)
          image.pixels[y * image.stride() + 3 * x + c] =
              static_cast<uint8_t>(std::lround(color[c]));
      }
    }
  });
  return image;
}

}  // namespace raygrid
