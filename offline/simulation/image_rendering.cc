#include "simulation/image_rendering.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "dataset/error.h"
#include "dataset/image_codecs.h"
#include "dataset/parallel_for.h"
#include "simulation/random.h"

namespace raygrid {
namespace {

// Rows of pixels that are rendered together.
constexpr int kStripRows = 64;
// Truncation radius of the lens blur, in standard deviations.
constexpr double kGaussianRadius = 4.5;
// Board coordinates are interpolated if the depth within 2 x 2 pixels varies by
// less than this ratio; for boards viewed nearly edge-on, directions are
// interpolated instead.
constexpr double kMaxDepthRatio = 1.05;

// Returns the observation line at the nearest pixel of an area, extrapolated
// quadratically.
std::optional<ObservationLine> LineNear(const CameraModel& camera,
                                        const Eigen::Vector2d& pixel) {
  const Area& area = camera.area();
  if (!area.Contains(pixel, 1)) return std::nullopt;
  const Eigen::Vector2d inside(std::clamp(pixel.x(), area.x0, area.x1),
                               std::clamp(pixel.y(), area.y0, area.y1));
  const auto first = camera.Line(inside);
  if (!first || inside == pixel) return first;
  const Eigen::Vector2d step = inside - pixel;
  const auto second = camera.Line(inside + step);
  const auto third = camera.Line(inside + 2 * step);
  if (!second || !third) return std::nullopt;
  return ObservationLine{
      3 * first->origin - 3 * second->origin + third->origin,
      (3 * first->direction - 3 * second->direction + third->direction)
          .normalized()};
}

// Weights of the samples around a pixel along one axis: the pixel's box filter
// convolved with the Gaussian of the lens.
struct Kernel {
  int radius_px = 0;           // pixels on each side
  std::vector<float> weights;  // (2 radius_px + 1) * samples_per_pixel of them
};

// Returns the integral of the normal cumulative distribution function.
double IntegrateNormalCdf(double x) {
  return x * 0.5 * std::erfc(-x / std::sqrt(2.0)) +
         std::exp(-x * x / 2) / std::sqrt(2 * M_PI);
}

// Returns the integral of the blurred box of one pixel from minus infinity to
// x.
double IntegrateBlurredBox(double x, double sigma) {
  if (sigma <= 0) return std::clamp(x + 0.5, 0.0, 1.0);
  return sigma * (IntegrateNormalCdf((x + 0.5) / sigma) -
                  IntegrateNormalCdf((x - 0.5) / sigma));
}

Kernel MakeBlurKernel(double blur_px, int samples_per_pixel) {
  // Subtracts the variance of a sample's own box.
  const double sample_px = 1.0 / samples_per_pixel;
  const double sigma =
      std::sqrt(std::max(0.0, blur_px * blur_px - sample_px * sample_px / 12));
  Kernel kernel;
  kernel.radius_px = static_cast<int>(std::ceil(kGaussianRadius * sigma));
  const int count = (2 * kernel.radius_px + 1) * samples_per_pixel;
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    const double x = i * sample_px - kernel.radius_px - 0.5;
    const double weight = IntegrateBlurredBox(x + sample_px, sigma) -
                          IntegrateBlurredBox(x, sigma);
    kernel.weights.push_back(static_cast<float>(weight));
    sum += weight;
  }
  for (float& weight : kernel.weights) weight /= static_cast<float>(sum);
  return kernel;
}

// Intersections of a board with the observation lines at the 3 x 3 corners of 2
// x 2 pixels.
struct BoardBlock {
  const BoardSurface* surface = nullptr;
  std::array<ObservationLine, 9> lines;  // in the board's coordinates
  std::array<Eigen::Vector2d, 9> points_m;
  double depth = 0;       // mean of the 9 points
  bool is_smooth = true;  // whether points_m may be interpolated
};

class Renderer {
 public:
  Renderer(const PixelRays& rays, const std::vector<PlacedBoard>& boards,
           const ImagingOptions& options)
      : rays_(rays),
        options_(options),
        samples_(options.samples_per_pixel),
        width_(rays.size().width),
        height_(rays.size().height),
        kernel_(MakeBlurKernel(options.blur_px, options.samples_per_pixel)) {
    for (const PlacedBoard& board : boards) {
      const Eigen::Quaterniond rotation =
          board.camera_from_board.rotation.conjugate();
      boards_.push_back({board.surface, rotation.toRotationMatrix(),
                         -(rotation * board.camera_from_board.translation)});
    }
    for (int i = 0; i < 2 * samples_; ++i) {
      const double u = (i + 0.5) / samples_;
      basis_.push_back({(u - 1) * (u - 2) / 2, u * (2 - u), u * (u - 1) / 2});
    }
  }

  // Renders rows [first, last) of the image.
  void RenderRows(int first, int last, float* levels) const;

 private:
  struct LocatedBoard {
    const BoardSurface* surface;
    Eigen::Matrix3d board_from_camera;
    Eigen::Vector3d camera_in_board;
  };

  bool IntersectBlock(const LocatedBoard& board, const RayRows& rays,
                      int column, int row, BoardBlock* block) const;
  void PaintSmooth(const BoardBlock& block, float* samples) const;
  void PaintEdgeOn(const BoardBlock& block, float* samples) const;
  void PaintSample(const BoardSurface& surface, const Eigen::Vector2d& point_m,
                   const Footprint& footprint, float* sample) const;
  void RenderBlock(const RayRows& rays, int column, int row,
                   float* samples) const;
  void FilterAlongRow(float* samples, float* filtered) const;
  int SamplesStride() const {
    return (width_ + 2 * kernel_.radius_px) * samples_;
  }

  const PixelRays& rays_;
  const ImagingOptions& options_;
  const int samples_;  // per pixel and axis
  const int width_, height_;
  const Kernel kernel_;
  std::vector<LocatedBoard> boards_;
  // Basis functions of quadratic interpolation at the samples of two pixels.
  std::vector<std::array<double, 3>> basis_;
};

// Intersects a board with a block; returns false if the board is not visible
// there.
bool Renderer::IntersectBlock(const LocatedBoard& board, const RayRows& rays,
                              int column, int row, BoardBlock* block) const {
  block->surface = board.surface;
  block->depth = 0;
  Eigen::Vector2d low(1e300, 1e300), high(-1e300, -1e300);
  double nearest = std::numeric_limits<double>::infinity(), farthest = 0;
  int count = 0;
  for (int k = 0; k < 9; ++k) {
    const ObservationLine& line = rays.Line(column + k % 3, row + k / 3);
    if (std::isnan(line.direction.x())) return false;
    block->lines[k] = {
        board.board_from_camera * line.origin + board.camera_in_board,
        board.board_from_camera * line.direction};
    const auto point = board.surface->Intersect(block->lines[k]);
    if (!point) continue;
    ++count;
    block->points_m[k] = point->board_m;
    block->depth += point->depth;
    nearest = std::min(nearest, point->depth);
    farthest = std::max(farthest, point->depth);
    low = low.cwiseMin(point->board_m);
    high = high.cwiseMax(point->board_m);
  }
  if (count == 0) return false;
  block->depth /= count;
  block->is_smooth = count == 9 && farthest < nearest * kMaxDepthRatio;
  if (count < 9) return true;
  // The quadratic interpolant overshoots by less than the extent of the points.
  const Eigen::Vector2d margin = high - low;
  const Area& paper = board.surface->paper_m();
  return low.x() - margin.x() < paper.x1 && high.x() + margin.x() > paper.x0 &&
         low.y() - margin.y() < paper.y1 && high.y() + margin.y() > paper.y0;
}

void Renderer::PaintSample(const BoardSurface& surface,
                           const Eigen::Vector2d& point_m,
                           const Footprint& footprint, float* sample) const {
  const double paper = surface.PaperFraction(point_m, footprint);
  if (paper <= 0) return;
  const double ink = surface.InkFraction(point_m, footprint);
  const double level = options_.white_level +
                       ink * (options_.black_level - options_.white_level);
  *sample += static_cast<float>(paper * (level - *sample));
}

void Renderer::PaintSmooth(const BoardBlock& block, float* samples) const {
  Eigen::Matrix2d sides_m;
  sides_m << block.points_m[5] - block.points_m[3],
      block.points_m[7] - block.points_m[1];
  const Footprint footprint(sides_m / (2 * samples_));
  for (int j = 0; j < 2 * samples_; ++j) {
    std::array<Eigen::Vector2d, 3> in_row;
    for (int k = 0; k < 3; ++k)
      in_row[k] = basis_[j][0] * block.points_m[k] +
                  basis_[j][1] * block.points_m[3 + k] +
                  basis_[j][2] * block.points_m[6 + k];
    for (int i = 0; i < 2 * samples_; ++i)
      PaintSample(*block.surface,
                  basis_[i][0] * in_row[0] + basis_[i][1] * in_row[1] +
                      basis_[i][2] * in_row[2],
                  footprint, samples + j * SamplesStride() + i);
  }
}

void Renderer::PaintEdgeOn(const BoardBlock& block, float* samples) const {
  const Footprint no_extent(Eigen::Matrix2d::Zero());
  for (int j = 0; j < 2 * samples_; ++j) {
    for (int i = 0; i < 2 * samples_; ++i) {
      ObservationLine line = {{0, 0, 0}, {0, 0, 0}};
      for (int k = 0; k < 9; ++k) {
        const double weight = basis_[j][k / 3] * basis_[i][k % 3];
        line.origin += weight * block.lines[k].origin;
        line.direction += weight * block.lines[k].direction;
      }
      const auto point = block.surface->Intersect(line);
      if (point)
        PaintSample(*block.surface, point->board_m, no_extent,
                    samples + j * SamplesStride() + i);
    }
  }
}

// Renders the samples of 2 x 2 pixels, the farthest boards first.
void Renderer::RenderBlock(const RayRows& rays, int column, int row,
                           float* samples) const {
  for (int j = 0; j < 2 * samples_; ++j)
    std::fill_n(samples + j * SamplesStride(), 2 * samples_,
                static_cast<float>(options_.background_level));
  std::vector<BoardBlock> seen;
  BoardBlock block;
  for (const LocatedBoard& board : boards_)
    if (IntersectBlock(board, rays, column, row, &block)) seen.push_back(block);
  std::sort(seen.begin(), seen.end(),
            [](const auto& a, const auto& b) { return a.depth > b.depth; });
  for (const BoardBlock& board : seen) {
    if (board.is_smooth) {
      PaintSmooth(board, samples);
    } else {
      PaintEdgeOn(board, samples);
    }
  }
}

// Filters the samples of a row, which is padded for the kernel on both sides,
// to pixels.
void Renderer::FilterAlongRow(float* samples, float* filtered) const {
  const int margin = kernel_.radius_px * samples_;
  const int end = margin + width_ * samples_;
  std::fill_n(samples, margin, samples[margin]);
  std::fill_n(samples + end, margin, samples[end - 1]);
  const int count = static_cast<int>(kernel_.weights.size());
  const Eigen::Map<const Eigen::VectorXf> weights(kernel_.weights.data(),
                                                  count);
  for (int x = 0; x < width_; ++x)
    filtered[x] = weights.dot(
        Eigen::Map<const Eigen::VectorXf>(samples + x * samples_, count));
}

void Renderer::RenderRows(int first, int last, float* levels) const {
  // Rows within the kernel's radius, in blocks of two.
  const int begin = std::max(0, first - kernel_.radius_px) / 2 * 2;
  const int end = std::min(height_, last + kernel_.radius_px);
  // A block of two rows that would exceed the image starts a row earlier.
  const auto rays =
      rays_.Rows(std::min(begin, height_ - 2), std::min(end + 1, height_));
  std::vector<float> samples(static_cast<size_t>(SamplesStride()) * 2 *
                             samples_);
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows(
      static_cast<Eigen::Index>(end - begin) * samples_, width_);
  for (int y = begin; y < end; y += 2) {
    const int row = std::min(y, height_ - 2);
    for (int x = 0; x < width_; x += 2) {
      const int column = std::min(x, width_ - 2);
      RenderBlock(*rays, column, row,
                  samples.data() + (kernel_.radius_px + column) * samples_);
    }
    for (int j = 0; j < 2 * samples_; ++j) {
      const int position = (row - begin) * samples_ + j;
      if (position >= 0 && position < rows.rows())
        FilterAlongRow(samples.data() + j * SamplesStride(),
                       rows.row(position).data());
    }
  }
  const int num_weights = static_cast<int>(kernel_.weights.size());
  for (int y = first; y < last; ++y) {
    Eigen::Map<Eigen::RowVectorXf> output(
        levels + static_cast<size_t>(y) * width_, width_);
    output.setZero();
    const Eigen::Index top =
        static_cast<Eigen::Index>(y - kernel_.radius_px - begin) * samples_;
    for (int k = 0; k < num_weights; ++k)
      output += kernel_.weights[k] *
                rows.row(std::clamp<Eigen::Index>(top + k, 0, rows.rows() - 1));
  }
}

// Returns the vignetting: cos^4 of an angle whose tangent is proportional to
// the distance from the centre; zero outside the image circle.
double Transmission(const CameraModel& camera, int column, int row,
                    double vignetting) {
  const ImageSize& size = camera.image_size();
  const double x = column - (size.width - 1) / 2.0;
  const double y = row - (size.height - 1) / 2.0;
  const double corner2 =
      (std::pow(size.width - 1, 2) + std::pow(size.height - 1, 2)) / 4;
  const double corner_tan2 = 1 / std::sqrt(1 - vignetting) - 1;
  double lit = 1;
  if (const auto& circle = camera.image_circle()) {
    const double radius_px = circle->radii_px.mean();
    const Eigen::Vector2d offset =
        Eigen::Vector2d(column, row) - circle->center;
    const double part = offset.cwiseQuotient(circle->radii_px).norm();
    lit = std::clamp((1 - part) * radius_px / 2 + 0.5, 0.0, 1.0);
  }
  return lit * std::pow(1 + corner_tan2 * (x * x + y * y) / corner2, -2);
}

void RequireValidView(const ImageSize& size, const ImagingOptions& options) {
  if (size.width < 2 || size.height < 2)
    throw InputError("images must be at least 2 x 2 pixels");
  if (options.samples_per_pixel < 1 || options.samples_per_pixel > 64)
    throw InputError("samples per pixel must be 1 to 64");
  if (!(options.blur_px >= 0 && options.blur_px <= 50))
    throw InputError("blur must be 0 to 50 px");
  if (!(options.vignetting >= 0 && options.vignetting < 1))
    throw InputError("vignetting must be at least 0 and below 1");
  if (!(options.gamma > 0)) throw InputError("gamma must be positive");
}

// Adds noise and passes levels from 0 to 255, not yet rounded, to store.
template <typename Store>
void AddNoise(const RenderedImage& image, const ImagingOptions& options,
              const Store& store) {
  const bool has_noise = options.read_noise > 0 || options.shot_noise > 0;
  for (int row = 0; row < image.size.height; ++row) {
    Random random(options.seed * 0x9e3779b97f4a7c15 + row);
    for (int column = 0; column < image.size.width; ++column) {
      const size_t index = static_cast<size_t>(row) * image.size.width + column;
      double level = image.levels[index];
      if (has_noise)
        level += random.Normal() *
                 std::sqrt(options.read_noise * options.read_noise +
                           options.shot_noise * std::max(level, 0.0));
      level = std::clamp(level, 0.0, 255.0);
      if (options.gamma != 1)
        level = 255 * std::pow(level / 255, 1 / options.gamma);
      store(index, level);
    }
  }
}

}  // namespace

RayRows::RayRows(const CameraModel& camera, int first, int last,
                 int num_threads)
    : columns_(camera.image_size().width + 1),
      first_row_(first),
      lines_(static_cast<size_t>(last + 1 - first) * columns_) {
  ParallelFor(last + 1 - first, num_threads, [&](int row) {
    for (int column = 0; column < columns_; ++column) {
      ObservationLine& line =
          lines_[static_cast<size_t>(row) * columns_ + column];
      const auto found =
          LineNear(camera, {column - 0.5, first_row_ + row - 0.5});
      line.direction.setConstant(std::numeric_limits<double>::quiet_NaN());
      if (found) line = *found;
    }
  });
}

PixelRays::PixelRays(const CameraModel& camera, int num_threads)
    : camera_(camera.Clone()) {
  constexpr size_t kMaxPixels = 5000000;
  const ImageSize& image = size();
  if (static_cast<size_t>(image.width) * image.height <= kMaxPixels)
    precomputed_rays_ =
        std::make_shared<RayRows>(camera, 0, image.height, num_threads);
}

std::shared_ptr<const RayRows> PixelRays::Rows(int first, int last) const {
  return precomputed_rays_
             ? precomputed_rays_
             : std::make_shared<RayRows>(*camera_, first, last, 1);
}

RenderedImage RenderImage(const PixelRays& rays,
                          const std::vector<PlacedBoard>& boards,
                          const ImagingOptions& options, int num_threads) {
  const ImageSize& size = rays.size();
  RequireValidView(size, options);
  RenderedImage image;
  image.size = size;
  image.levels.resize(static_cast<size_t>(size.width) * size.height);
  const Renderer renderer(rays, boards, options);
  const int num_strips = (size.height + kStripRows - 1) / kStripRows;
  ParallelFor(num_strips, num_threads, [&](int strip) {
    const int first = strip * kStripRows;
    const int last = std::min(first + kStripRows, size.height);
    renderer.RenderRows(first, last, image.levels.data());
    for (int row = first; row < last; ++row)
      for (int column = 0; column < size.width; ++column)
        image.levels[static_cast<size_t>(row) * size.width + column] *=
            static_cast<float>(
                options.exposure *
                Transmission(rays.camera(), column, row, options.vignetting));
  });
  return image;
}

Image AddNoiseAndQuantize(const RenderedImage& image,
                          const ImagingOptions& options) {
  Image stored;
  stored.size = image.size;
  stored.pixels.resize(image.levels.size());
  AddNoise(image, options, [&stored](size_t index, double level) {
    stored.pixels[index] = static_cast<uint8_t>(level + 0.5);
  });
  return stored;
}

Image16 AddNoiseAndQuantize16(const RenderedImage& image,
                              const ImagingOptions& options) {
  Image16 stored;
  stored.size = image.size;
  stored.pixels.resize(image.levels.size());
  AddNoise(image, options, [&stored](size_t index, double level) {
    stored.pixels[index] = static_cast<uint16_t>(level * 257 + 0.5);
  });
  return stored;
}

std::string EncodePng(const Image16& image) {
  const cv::Mat pixels(image.size.height, image.size.width, CV_16U,
                       const_cast<uint16_t*>(image.pixels.data()));
  return EncodePng(pixels);
}

}  // namespace raygrid
