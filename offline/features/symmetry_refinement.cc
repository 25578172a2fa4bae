#include "features/symmetry_refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

namespace raygrid {
namespace {

// Parameters: center, perspective, linear; or center alone.
template <int N>
using ParameterVector = Eigen::Matrix<float, N, 1>;
template <int N>
using ParameterMatrix = Eigen::Matrix<float, N, N>;

// The pairs of one feature, as structure of arrays.
struct Pairs {
  std::vector<float> u, v;            // offset on the board
  std::vector<float> even_x, even_y;  // W m(s) enlarged: even part
  std::vector<float> odd_x, odd_y;    // and its odd part
  size_t size() const { return u.size(); }
};

Pairs MakePairs(const SymmetryImage& image, const SymmetrySamples& samples,
                const SymmetryMask& mask, const LocalMapping& start,
                size_t stride) {
  Pairs pairs;
  const Eigen::Matrix2f inverse = start.linear.inverse().cast<float>();
  const auto w =
      (SymmetryImage::kEnlargement * start.curvature).cast<float>().eval();
  const Eigen::Vector2f center = start.center.cast<float>();
  constexpr float kBorderPx = 1.5f;
  constexpr int kScale = SymmetryImage::kEnlargement;
  const float x1 = image.size.width / kScale - 1 - kBorderPx;
  const float y1 = image.size.height / kScale - 1 - kBorderPx;
  for (size_t i = 0; i < samples.x.size(); i += stride) {
    const float dx = samples.x[i], dy = samples.y[i];
    if (std::min(center.x() - std::fabs(dx), center.y() - std::fabs(dy)) <
            kBorderPx ||
        center.x() + std::fabs(dx) > x1 || center.y() + std::fabs(dy) > y1)
      continue;
    const float u = inverse(0, 0) * dx + inverse(0, 1) * dy;
    const float v = inverse(1, 0) * dx + inverse(1, 1) * dy;
    if (!mask.IsSymmetric(u, v)) continue;
    pairs.u.push_back(u);
    pairs.v.push_back(v);
    const float uu = u * u, uv = u * v, vv = v * v;
    pairs.even_x.push_back(w(0, 0) * uu + w(0, 1) * uv + w(0, 2) * vv);
    pairs.even_y.push_back(w(1, 0) * uu + w(1, 1) * uv + w(1, 2) * vv);
    pairs.odd_x.push_back(u * (w(0, 3) * uu + w(0, 4) * uv + w(0, 5) * vv) +
                          w(0, 6) * v * vv);
    pairs.odd_y.push_back(u * (w(1, 3) * uu + w(1, 4) * uv + w(1, 5) * vv) +
                          w(1, 6) * v * vv);
  }
  return pairs;
}

// A value and its gradient by bilinear interpolation.
struct Sampled {
  float value, dx, dy;
};

inline Sampled Bilinear(const float* pixels, int width, float x, float y) {
  // Positive for the conversion, so that it rounds down.
  constexpr int kShift = 256;
  const int ix = static_cast<int>(x + kShift) - kShift;
  const int iy = static_cast<int>(y + kShift) - kShift;
  const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
  const float* p = pixels + iy * width + ix;
  const float top = p[1] - p[0], bottom = p[width + 1] - p[width];
  const float left = p[0] + fx * top, right = p[width] + fx * bottom;
  return {left + fy * (right - left), top + fy * (bottom - top), right - left};
}

template <int N>
struct System {
  ParameterMatrix<N> hessian = ParameterMatrix<N>::Zero();
  ParameterVector<N> gradient = ParameterVector<N>::Zero();
  double cost = 0;
  double sum = 0, sum_squares = 0;  // of the values
  int count = 0;
};

// A pair's two places, in the enlarged image.
struct Places {
  float nx, ny;  // A s
  float q, r;    // 1 / (1 + h s), 1 / (1 - h s)
  float ax, ay, bx, by;
};

// Positions are relative to base, an integer pixel: floats keep their
// precision.
class Problem {
 public:
  Problem(const SymmetryImage& image, const Pairs& pairs, bool inverts_colors,
          const Eigen::Vector2i& base)
      : image_(image), pairs_(pairs), base_(base) {
    sign_ = inverts_colors ? image.inverted_reflection : image.reflection;
    has_middle_ = sign_ < 0 && image.has_middle;
  }

  template <int N>
  System<N> Evaluate(const LocalMapping& mapping) const {
    const Parameters parameters = ToFloat(mapping);
    System<N> system;
    for (const std::vector<float>& channel : image_.channels) {
      const float* origin =
          &channel[kScale * base_.y() * image_.size.width + kScale * base_.x()];
      const float twice_middle =
          has_middle_ ? MeanSum(origin, parameters) : 0.f;
      Accumulate(origin, parameters, twice_middle, &system);
    }
    return system;
  }

 private:
  static constexpr int kScale = SymmetryImage::kEnlargement;

  // Of a LocalMapping, in enlarged pixels from base.
  struct Parameters {
    float a00, a01, a10, a11, h0, h1, cx, cy;
  };
  Parameters ToFloat(const LocalMapping& m) const {
    const Eigen::Matrix2f a = (kScale * m.linear).cast<float>();
    const Eigen::Vector2f c =
        (kScale * (m.center - base_.cast<double>())).cast<float>();
    const Eigen::Vector2f h = m.perspective.cast<float>();
    return {a(0, 0), a(0, 1), a(1, 0), a(1, 1), h.x(), h.y(), c.x(), c.y()};
  }

  Places PlacesOf(const Parameters& p, size_t i) const {
    Places places;
    const float u = pairs_.u[i], v = pairs_.v[i];
    const float d = p.h0 * u + p.h1 * v;
    places.nx = p.a00 * u + p.a01 * v;
    places.ny = p.a10 * u + p.a11 * v;
    places.q = 1 / (1 + d);
    places.r = 1 / (1 - d);
    const float mx = p.cx + pairs_.even_x[i], my = p.cy + pairs_.even_y[i];
    places.ax = mx + (places.nx * places.q + pairs_.odd_x[i]);
    places.ay = my + (places.ny * places.q + pairs_.odd_y[i]);
    places.bx = mx - (places.nx * places.r + pairs_.odd_x[i]);
    places.by = my - (places.ny * places.r + pairs_.odd_y[i]);
    return places;
  }

  float MeanSum(const float* origin, const Parameters& p) const {
    double sum = 0;
    for (size_t i = 0; i < pairs_.size(); ++i) {
      const Places at = PlacesOf(p, i);
      sum += Sample(origin, at.ax, at.ay).value +
             Sample(origin, at.bx, at.by).value;
    }
    return static_cast<float>(sum / static_cast<double>(pairs_.size()));
  }

  Sampled Sample(const float* origin, float x, float y) const {
    const float left = static_cast<float>(-kScale * base_.x());
    const float top = static_cast<float>(-kScale * base_.y());
    x = std::clamp(x, left, left + static_cast<float>(image_.size.width - 2));
    y = std::clamp(y, top, top + static_cast<float>(image_.size.height - 2));
    return Bilinear(origin, image_.size.width, x, y);
  }

  template <int N>
  void Accumulate(const float* origin, const Parameters& p, float twice_middle,
                  System<N>* system) const {
    float h[N][N] = {}, g[N] = {};
    float cost = 0, sum = 0, sum_squares = 0;
    for (size_t i = 0; i < pairs_.size(); ++i) {
      const Places at = PlacesOf(p, i);
      const Sampled a = Sample(origin, at.ax, at.ay);
      Sampled b = Sample(origin, at.bx, at.by);
      const float residual = a.value - sign_ * b.value - twice_middle;
      b.dx *= sign_;
      b.dy *= sign_;
      float j[8];
      j[0] = kScale * (a.dx - b.dx);
      j[1] = kScale * (a.dy - b.dy);
      if (N == 8) AddHomography(at, a, b, pairs_.u[i], pairs_.v[i], j);
      for (int row = 0; row < N; ++row) {
        for (int column = 0; column < N; ++column)
          h[row][column] += j[row] * j[column];
        g[row] += j[row] * residual;
      }
      cost += residual * residual;
      sum += a.value;
      sum_squares += a.value * a.value;
    }
    for (int row = 0; row < N; ++row) {
      for (int column = 0; column < N; ++column)
        system->hessian(row, column) += h[row][column];
      system->gradient[row] += g[row];
    }
    system->cost += cost;
    system->sum += sum;
    system->sum_squares += sum_squares;
    system->count += static_cast<int>(pairs_.size());
  }

  // d x(+-s) / d h = -A s u / (1 +- h s)^2, d x(+-s) / d A = +-u / (1 +- h s).
  static void AddHomography(const Places& at, const Sampled& a,
                            const Sampled& b, float u, float v, float* j) {
    const float by_h = (b.dx * at.nx + b.dy * at.ny) * at.r * at.r -
                       (a.dx * at.nx + a.dy * at.ny) * at.q * at.q;
    const float by_x = kScale * (a.dx * at.q + b.dx * at.r);
    const float by_y = kScale * (a.dy * at.q + b.dy * at.r);
    j[2] = by_h * u;
    j[3] = by_h * v;
    j[4] = by_x * u;
    j[5] = by_x * v;
    j[6] = by_y * u;
    j[7] = by_y * v;
  }

  const SymmetryImage& image_;
  const Pairs& pairs_;
  Eigen::Vector2i base_;
  float sign_;
  bool has_middle_;
};

template <int N>
LocalMapping Moved(LocalMapping mapping, const ParameterVector<N>& step_float) {
  const Eigen::Matrix<double, N, 1> step = step_float.template cast<double>();
  mapping.center += step.template head<2>();
  if constexpr (N == 8) {
    mapping.perspective += step.template segment<2>(2);
    mapping.linear.row(0) += step.template segment<2>(4).transpose();
    mapping.linear.row(1) += step.template segment<2>(6).transpose();
  }
  return mapping;
}

struct Limits {
  int max_iterations;
  double converged_px;
  double max_move_px;
};

// Levenberg and Marquardt's method; the state after it. False if it left the
// neighbourhood of start.
template <int N>
bool Minimize(const Problem& problem, const LocalMapping& start,
              const Limits& limits, LocalMapping* mapping, System<N>* system) {
  float lambda = N == 2 ? 0 : 1e-3f;
  *system = problem.Evaluate<N>(*mapping);
  for (int iteration = 0; iteration < limits.max_iterations; ++iteration) {
    ParameterMatrix<N> damped = system->hessian;
    constexpr float kFloor = 1e-6f;  // of the largest diagonal element
    damped.diagonal() *= 1 + lambda;
    damped.diagonal().array() += kFloor * damped.diagonal().maxCoeff();
    const ParameterVector<N> step = -damped.ldlt().solve(system->gradient);
    if (!step.allFinite()) return false;
    const LocalMapping candidate = Moved<N>(*mapping, step);
    if ((candidate.center - start.center).norm() > limits.max_move_px)
      return false;
    const double moved_px = (candidate.center - mapping->center).norm();
    const System<N> next = problem.Evaluate<N>(candidate);
    if (next.cost <= system->cost) {
      *mapping = candidate;
      *system = next;
      lambda /= 4;
    } else {
      lambda = std::max(8 * lambda, 1e-3f);
    }
    if (moved_px < limits.converged_px) break;
  }
  return true;
}

template <int N>
void Refine(const SymmetryImage& image, const SymmetrySamples& samples,
            const SymmetryMask& mask, const LocalMapping& start,
            bool inverts_colors, double max_move_px, SymmetryResult* result) {
  const Eigen::Vector2i base = start.center.cast<int>();
  System<N> system;
  // With one sample a pixel first, then with all.
  constexpr size_t kCoarse = 8;
  for (const size_t stride : {kCoarse, size_t{1}}) {
    const Pairs pairs = MakePairs(image, samples, mask, start, stride);
    constexpr size_t kMinPixelPairs = 30;
    if (pairs.size() * stride < kMinPixelPairs * kCoarse) return;
    const Problem problem(image, pairs, inverts_colors, base);
    const Limits limits = stride == 1 ? Limits{3, 1e-3, max_move_px}
                                      : Limits{12, 5e-3, max_move_px};
    if (!Minimize<N>(problem, start, limits, &result->mapping, &system)) return;
  }
  const double n = system.count, mean = system.sum / n;
  result->is_converged = true;
  result->rms = std::sqrt(system.cost / n);
  result->contrast =
      std::sqrt(std::max(0.0, system.sum_squares / n - mean * mean));
}

// The value between two pixels from the four on each side: sin(pi x) / (pi x)
// in a window of the same form, four times as wide (Lanczos).
constexpr float kHalfway[4] = {0.61892f, -0.16603f, 0.05972f, -0.01261f};

// Puts halfway values between those of each row.
std::vector<float> EnlargedRows(const std::vector<float>& values, int width,
                                int height) {
  std::vector<float> enlarged(values.size() * 2);
  for (int y = 0; y < height; ++y) {
    const float* in = &values[static_cast<size_t>(y) * width];
    float* out = &enlarged[static_cast<size_t>(y) * width * 2];
    const auto at = [&](int x) { return in[std::clamp(x, 0, width - 1)]; };
    const auto halfway = [](float a0, float a1, float a2, float a3, float b0,
                            float b1, float b2, float b3) {
      return kHalfway[0] * (a0 + b0) + kHalfway[1] * (a1 + b1) +
             kHalfway[2] * (a2 + b2) + kHalfway[3] * (a3 + b3);
    };
    for (int x = 0; x < width; ++x) {
      out[2 * x] = in[x];
      out[2 * x + 1] =
          x >= 3 && x + 4 < width
              ? halfway(in[x], in[x - 1], in[x - 2], in[x - 3], in[x + 1],
                        in[x + 2], in[x + 3], in[x + 4])
              : halfway(at(x), at(x - 1), at(x - 2), at(x - 3), at(x + 1),
                        at(x + 2), at(x + 3), at(x + 4));
    }
  }
  return enlarged;
}

// Puts halfway rows between the rows.
std::vector<float> EnlargedColumns(const std::vector<float>& values, int width,
                                   int height) {
  std::vector<float> enlarged(values.size() * 2);
  for (int y = 0; y < height; ++y) {
    const float* rows[8];
    for (int k = 0; k < 8; ++k)
      rows[k] =
          &values[static_cast<size_t>(std::clamp(y - 3 + k, 0, height - 1)) *
                  width];
    float* out = &enlarged[static_cast<size_t>(y) * width * 2];
    std::copy(rows[3], rows[3] + width, out);
    out += width;
    for (int x = 0; x < width; ++x)
      out[x] = kHalfway[0] * (rows[3][x] + rows[4][x]) +
               kHalfway[1] * (rows[2][x] + rows[5][x]) +
               kHalfway[2] * (rows[1][x] + rows[6][x]) +
               kHalfway[3] * (rows[0][x] + rows[7][x]);
  }
  return enlarged;
}

}  // namespace

SymmetrySamples MakeSymmetrySamples(int window_px, int samples_per_pixel) {
  SymmetrySamples samples;
  std::mt19937 engine(1);
  const auto uniform = [&engine] {
    return static_cast<float>(engine() >> 8) * 0x1p-24f - 0.5f;
  };
  // Half of the window: the other half are the mirrored partners. Pixels come
  // in the inner loop, so that every n-th sample covers the window as well.
  const int half = window_px / 2;
  for (int k = 0; k < samples_per_pixel; ++k) {
    for (int y = 0; y <= half; ++y) {
      for (int x = -half; x <= half; ++x) {
        if (y == 0 && x < 0) continue;
        samples.x.push_back(x + uniform());
        samples.y.push_back(y + uniform());
      }
    }
  }
  return samples;
}

SymmetryImage MakeSymmetryImage(const GreyImage& image, Refinement refinement) {
  SymmetryImage result;
  result.size = {2 * image.size.width, 2 * image.size.height};
  const int w = result.size.width, h = result.size.height;
  std::vector<float> levels = EnlargedColumns(
      EnlargedRows(image.levels, image.size.width, image.size.height), w,
      image.size.height);
  if (refinement != Refinement::kGradientsXY &&
      refinement != Refinement::kGradientMagnitude) {
    result.channels = {std::move(levels)};
    return result;
  }
  std::vector<float> gx(levels.size(), 0), gy(levels.size(), 0);
  for (int y = 1; y + 1 < h; ++y) {
    for (int x = 1; x + 1 < w; ++x) {
      const float* p = &levels[static_cast<size_t>(y) * w + x];
      gx[static_cast<size_t>(y) * w + x] = p[1] - p[-1];
      gy[static_cast<size_t>(y) * w + x] = p[w] - p[-w];
    }
  }
  if (refinement == Refinement::kGradientsXY) {
    result.channels = {std::move(gx), std::move(gy)};
    result.reflection = -1;
    result.inverted_reflection = 1;
    result.has_middle = false;
    return result;
  }
  for (size_t i = 0; i < gx.size(); ++i)
    gx[i] = std::sqrt(gx[i] * gx[i] + gy[i] * gy[i]);
  result.channels = {std::move(gx)};
  result.inverted_reflection = 1;
  return result;
}

SymmetryResult RefineSymmetry(const SymmetryImage& image,
                              const SymmetrySamples& samples,
                              const SymmetryMask& mask,
                              const LocalMapping& start, bool inverts_colors,
                              bool center_only, double max_move_px) {
  SymmetryResult result;
  result.mapping = start;
  const auto refine = center_only ? Refine<2> : Refine<8>;
  refine(image, samples, mask, start, inverts_colors, max_move_px, &result);
  return result;
}

}  // namespace raygrid
