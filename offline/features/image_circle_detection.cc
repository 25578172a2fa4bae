#include "features/image_circle_detection.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "dataset/error.h"
#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

// A cell is illuminated if its level exceeds this fraction of the range from
// the dark level to the level at the image centre.
constexpr double kIlluminatedFraction = 0.1;
// An edge is sharp if levels exceed kSharpFraction of the range at a distance
// of kMaxSharpWidth, as a fraction of the radius, inside it. Vignetting alone
// does not produce such an edge.
constexpr double kSharpFraction = 0.2, kMaxSharpWidth = 0.04;
constexpr int kDirections = 720;
// A quadrant of the circle is visible if at least kMinEdgePixelsPerQuarter of
// the kDirections directions intersect the circle there.
constexpr int kMinEdgePixelsPerQuarter = 8, kMinVisibleQuarters = 3;
constexpr double kMinInliers = 0.7;
// Maximum fraction of illuminated cells outside the circle, as by reflections.
constexpr double kMaxIlluminatedFractionOutside = 0.005;

struct Circle {
  Eigen::Vector2d center;
  double radius_px = 0;

  double DistanceTo(const Eigen::Vector2d& pixel) const {
    return std::abs((pixel - center).norm() - radius_px);
  }
};

struct Thresholds {
  double lit = 0,
         sharp = 0;  // thresholds of kIlluminatedFraction and kSharpFraction
};

// Computes thresholds between the dark level, which is the 0.5 % quantile of
// the cells, and the median of cells in the central half of rows and columns.
std::optional<Thresholds> ComputeThresholds(const BrightestCells& cells) {
  std::vector<float> midpoint, all = cells.levels;
  for (int row = cells.rows / 4; row < cells.rows * 3 / 4; ++row)
    for (int column = cells.columns / 4; column < cells.columns * 3 / 4;
         ++column)
      midpoint.push_back(cells.levels[row * cells.columns + column]);
  if (midpoint.empty()) return std::nullopt;
  const auto nth = [](std::vector<float>* values, size_t n) {
    std::nth_element(values->begin(), values->begin() + n, values->end());
    return static_cast<double>((*values)[n]);
  };
  const double bright = nth(&midpoint, midpoint.size() / 2);
  const double dark = nth(&all, all.size() / 200);
  if (!(dark < kIlluminatedFraction * bright)) return std::nullopt;
  return Thresholds{dark + kIlluminatedFraction * (bright - dark),
                    dark + kSharpFraction * (bright - dark)};
}

// Returns, for each direction from the image centre, the outermost pixel where
// images change from illuminated to dark, if there is one.
std::vector<Eigen::Vector2d> EdgePixels(const BrightestCells& cells,
                                        double lit) {
  const double step = cells.knot_spacing_px / 4.0;
  const Eigen::Vector2d midpoint =
      Eigen::Vector2d(cells.columns, cells.rows) * cells.knot_spacing_px / 2 -
      Eigen::Vector2d::Constant(0.5);
  std::vector<Eigen::Vector2d> edge;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * M_PI * k / kDirections;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    double level = 0, lit_at = -1, lit_level = 0, level_beyond = -1;
    for (double at = 0; cells.IsInside(midpoint + at * direction); at += step) {
      level = cells.At(midpoint + at * direction);
      if (level > lit) {
        lit_at = at;
        lit_level = level;
        level_beyond = -1;
      } else if (level_beyond < 0) {
        level_beyond = level;
      }
    }
    if (lit_at < 0 || level_beyond < 0) continue;
    const double part = (lit_level - lit) / (lit_level - level_beyond);
    edge.push_back(midpoint + (lit_at + part * step) * direction);
  }
  return edge;
}

// Fits the circle x^2 + y^2 + a x + b y + c = 0 by least squares.
std::optional<Circle> FitCircle(const std::vector<Eigen::Vector2d>& pixels) {
  if (pixels.size() < 3) return std::nullopt;
  Eigen::Vector2d mean(0, 0);
  for (const Eigen::Vector2d& pixel : pixels) mean += pixel;
  mean /= static_cast<double>(pixels.size());
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Eigen::Vector2d& pixel : pixels) {
    const Eigen::Vector2d offset = pixel - mean;
    const Eigen::Vector3d row(offset.x(), offset.y(), 1);
    square += row * row.transpose();
    right -= row * offset.squaredNorm();
  }
  const Eigen::Vector3d abc = square.ldlt().solve(right);
  const double square_radius = abc.head<2>().squaredNorm() / 4 - abc[2];
  if (!(square_radius > 0) || !abc.allFinite()) return std::nullopt;
  return Circle{mean - abc.head<2>() / 2, std::sqrt(square_radius)};
}

std::vector<Eigen::Vector2d> Near(const Circle& circle, double distance_px,
                                  const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<Eigen::Vector2d> near;
  for (const Eigen::Vector2d& pixel : pixels)
    if (circle.DistanceTo(pixel) <= distance_px) near.push_back(pixel);
  return near;
}

// Returns the circle with the most inliers among circles through three distant
// edge pixels (RANSAC).
std::optional<Circle> FitCircleRansac(const std::vector<Eigen::Vector2d>& edge,
                                      double knot_spacing_px) {
  std::optional<Circle> best;
  size_t most = 0;
  for (size_t k = 0; k < edge.size(); ++k) {
    const auto circle =
        FitCircle({edge[k], edge[(k + edge.size() / 3) % edge.size()],
                   edge[(k + edge.size() * 2 / 3) % edge.size()]});
    if (!circle) continue;
    const size_t count = Near(*circle, 1.5 * knot_spacing_px, edge).size();
    if (count <= most) continue;
    most = count;
    best = circle;
  }
  for (int round = 0; best && round < 3; ++round)
    best = FitCircle(Near(*best, 1.5 * knot_spacing_px, edge));
  return best;
}

bool IsCircleVisible(const Circle& circle,
                     const std::vector<Eigen::Vector2d>& edge) {
  std::array<int, 4> quarters = {};
  for (const Eigen::Vector2d& pixel : edge)
    ++quarters[(pixel.x() > circle.center.x()) +
               2 * (pixel.y() > circle.center.y())];
  return std::count_if(quarters.begin(), quarters.end(), [](int count) {
           return count >= kMinEdgePixelsPerQuarter;
         }) >= kMinVisibleQuarters;
}

// Whether images are bright just inside most edge pixels.
bool IsSharp(const BrightestCells& cells, double sharp, const Circle& circle,
             const std::vector<Eigen::Vector2d>& edge) {
  const auto bright = std::count_if(
      edge.begin(), edge.end(), [&](const Eigen::Vector2d& pixel) {
        return cells.At(pixel + kMaxSharpWidth * (circle.center - pixel)) >
               sharp;
      });
  return 2 * static_cast<size_t>(bright) > edge.size();
}

bool IsDarkOutside(const BrightestCells& cells, double lit,
                   const Circle& circle) {
  int num_beyond = 0, num_lit = 0;
  for (int row = 0; row < cells.rows; ++row)
    for (int column = 0; column < cells.columns; ++column) {
      const Eigen::Vector2d pixel =
          Eigen::Vector2d(column + 0.5, row + 0.5) * cells.knot_spacing_px -
          Eigen::Vector2d::Constant(0.5);
      if ((pixel - circle.center).norm() <
          circle.radius_px + 2 * cells.knot_spacing_px)
        continue;
      ++num_beyond;
      num_lit += cells.levels[row * cells.columns + column] > lit;
    }
  return num_lit <= kMaxIlluminatedFractionOutside * num_beyond;
}

}  // namespace

BrightestCells BrightestCells::Over(const ImageSize& size) {
  constexpr int kCells = 320;
  BrightestCells cells;
  cells.knot_spacing_px =
      std::max(1, std::max(size.width, size.height) / kCells);
  cells.columns = size.width / cells.knot_spacing_px;
  cells.rows = size.height / cells.knot_spacing_px;
  cells.levels.assign(static_cast<size_t>(cells.columns) * cells.rows, 0);
  return cells;
}

void BrightestCells::Add(const GreyLevels& image) {
  std::vector<float> sums(columns);
  for (int row = 0; row < rows; ++row) {
    std::fill(sums.begin(), sums.end(), 0.f);
    for (int y = row * knot_spacing_px; y < (row + 1) * knot_spacing_px; ++y) {
      const float* const pixels =
          image.levels.data() + static_cast<size_t>(y) * image.size.width;
      for (int x = 0; x < columns * knot_spacing_px; ++x)
        sums[x / knot_spacing_px] += pixels[x];
    }
    for (int column = 0; column < columns; ++column) {
      float& level = levels[static_cast<size_t>(row) * columns + column];
      level = std::max(
          level, sums[column] /
                     (static_cast<float>(knot_spacing_px) * knot_spacing_px));
    }
  }
}

void BrightestCells::Add(const BrightestCells& other) {
  for (size_t i = 0; i < levels.size(); ++i)
    levels[i] = std::max(levels[i], other.levels[i]);
}

double BrightestCells::At(const Eigen::Vector2d& pixel) const {
  const double x =
      std::clamp((pixel.x() + 0.5) / knot_spacing_px - 0.5, 0.0, columns - 1.0);
  const double y =
      std::clamp((pixel.y() + 0.5) / knot_spacing_px - 0.5, 0.0, rows - 1.0);
  const int column = std::min(static_cast<int>(x), std::max(columns - 2, 0));
  const int row = std::min(static_cast<int>(y), std::max(rows - 2, 0));
  const auto level = [&](int i, int j) {
    return static_cast<double>(
        levels[static_cast<size_t>(std::min(row + j, rows - 1)) * columns +
               std::min(column + i, columns - 1)]);
  };
  const double dx = x - column, dy = y - row;
  return (1 - dy) * ((1 - dx) * level(0, 0) + dx * level(1, 0)) +
         dy * ((1 - dx) * level(0, 1) + dx * level(1, 1));
}

bool BrightestCells::IsInside(const Eigen::Vector2d& pixel) const {
  return pixel.x() >= -0.5 && pixel.y() >= -0.5 &&
         pixel.x() <= columns * knot_spacing_px - 0.5 &&
         pixel.y() <= rows * knot_spacing_px - 0.5;
}

std::optional<ImageCircle> FindImageCircle(const BrightestCells& brightest) {
  const auto levels = ComputeThresholds(brightest);
  if (!levels) return std::nullopt;
  const std::vector<Eigen::Vector2d> edge = EdgePixels(brightest, levels->lit);
  const auto circle = FitCircleRansac(edge, brightest.knot_spacing_px);
  if (!circle) return std::nullopt;
  const std::vector<Eigen::Vector2d> near =
      Near(*circle, 1.5 * brightest.knot_spacing_px, edge);
  if (static_cast<double>(near.size()) <
          kMinInliers * static_cast<double>(edge.size()) ||
      !IsCircleVisible(*circle, near) ||
      !IsSharp(brightest, levels->sharp, *circle, near) ||
      !IsDarkOutside(brightest, levels->lit, *circle))
    return std::nullopt;
  return ImageCircle{circle->center,
                     Eigen::Vector2d::Constant(circle->radius_px)};
}

std::optional<ImageCircle> DetectImageCircle(
    const std::vector<std::string>& image_paths, const ImageSize& size,
    int num_threads) {
  constexpr size_t kMaxImages = 40;
  if (image_paths.empty()) return std::nullopt;
  const size_t step = (image_paths.size() + kMaxImages - 1) / kMaxImages;
  const int count = static_cast<int>((image_paths.size() + step - 1) / step);
  std::vector<BrightestCells> cells(count, BrightestCells::Over(size));
  ParallelFor(count, NumThreads(num_threads), [&](int i) {
    const std::string& path = image_paths[i * step];
    const GreyLevels image = ReadGreyLevels(path);
    if (image.size != size)
      throw InputError(
          path +
          ": the image was modified while raygrid was running; run it again");
    cells[i].Add(image);
  });
  for (int i = 1; i < count; ++i) cells[0].Add(cells[i]);
  return FindImageCircle(cells[0]);
}

}  // namespace raygrid
