#include "features/refinement/symmetry_refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "features/refinement/float_lanes.h"
#include "features/refinement/symmetry_patch.h"

namespace raygrid {
namespace {

// Parameters: center, perspective, linear (N = 8), or center only (N = 2).
template <int N>
using ParameterVector = Eigen::Matrix<float, N, 1>;
template <int N>
using ParameterMatrix = Eigen::Matrix<float, N, N>;

constexpr float kScale = SymmetryPatch::kEnlargement;
// Maximum distance of samples from the window due to curvature.
constexpr float kWindowMarginPx = 3;
constexpr float kBorderPx = 1.5f;  // unused border of the image

// Sample pairs of one feature as structure of arrays; lengths in upsampled
// pixels.
struct Pairs {
  std::vector<float> u, v;            // board offset s in squares
  std::vector<float> even_x, even_y;  // W m(s): even part
  std::vector<float> odd_x, odd_y;    // odd part
  std::vector<float> ax, ay, bx, by;  // x(s), x(-s) relative to the centre
  size_t size() const { return u.size(); }

  void Resize(size_t size) {
    for (auto* column :
         {&u, &v, &even_x, &even_y, &odd_x, &odd_y, &ax, &ay, &bx, &by})
      column->resize(size);
  }
};

inline FloatLanes Absolute(FloatLanes x) {
  return reinterpret_cast<FloatLanes>(reinterpret_cast<IntLanes>(x) &
                                      0x7fffffff);
}

// Computes sample pairs from the initial mapping.
class PairMaker {
 public:
  PairMaker(const ImageSize& size, int window_px, const LocalMapping& start)
      : linear_(kScale * start.linear.cast<float>()),
        inverse_(start.linear.inverse().cast<float>()),
        perspective_(start.perspective.cast<float>()),
        w_(kScale * start.curvature.cast<float>()),
        center_(start.center.cast<float>()),
        x1_(size.width - 1 - kBorderPx),
        y1_(size.height - 1 - kBorderPx),
        reach_(kScale * (window_px / 2 + kWindowMarginPx)) {}

  // Appends the pairs of the first num_lanes samples at index i. Omits pairs
  // with a sample outside the image or the symmetric area. Returns the number
  // of pairs. (u, v) = A^-1 (dx, dy).
  size_t Make(FloatLanes dx, FloatLanes dy, int num_lanes,
              const SymmetryMask& mask, size_t i, Pairs* pairs) const {
    const FloatLanes ex = Absolute(dx), ey = Absolute(dy);
    const FloatLanes u = inverse_(0, 0) * dx + inverse_(0, 1) * dy;
    const FloatLanes v = inverse_(1, 0) * dx + inverse_(1, 1) * dy;
    const FloatLanes uu = u * u, uv = u * v, vv = v * v;
    const FloatLanes even_x = w_(0, 0) * uu + w_(0, 1) * uv + w_(0, 2) * vv;
    const FloatLanes even_y = w_(1, 0) * uu + w_(1, 1) * uv + w_(1, 2) * vv;
    const FloatLanes odd_x =
        u * (w_(0, 3) * uu + w_(0, 4) * uv + w_(0, 5) * vv) + w_(0, 6) * v * vv;
    const FloatLanes odd_y =
        u * (w_(1, 3) * uu + w_(1, 4) * uv + w_(1, 5) * vv) + w_(1, 6) * v * vv;
    const FloatLanes nx = linear_(0, 0) * u + linear_(0, 1) * v;
    const FloatLanes ny = linear_(1, 0) * u + linear_(1, 1) * v;
    const FloatLanes d = perspective_.x() * u + perspective_.y() * v;
    const FloatLanes q = 1 / (1 + d), r = 1 / (1 - d);
    const FloatLanes ax = even_x + (nx * q + odd_x);
    const FloatLanes ay = even_y + (ny * q + odd_y);
    const FloatLanes bx = even_x - (nx * r + odd_x);
    const FloatLanes by = even_y - (ny * r + odd_y);
    const IntLanes is_inside =
        (center_.x() - ex >= kBorderPx) & (center_.y() - ey >= kBorderPx) &
        (center_.x() + ex <= x1_) & (center_.y() + ey <= y1_) &
        (Absolute(ax) <= reach_) & (Absolute(ay) <= reach_) &
        (Absolute(bx) <= reach_) & (Absolute(by) <= reach_);
    size_t count = 0;
    for (int k = 0; k < num_lanes; ++k) {
      if (!is_inside[k] || !mask.IsSymmetric(u[k], v[k])) continue;
      const size_t at = i + count++;
      pairs->u[at] = u[k];
      pairs->v[at] = v[k];
      pairs->even_x[at] = even_x[k];
      pairs->even_y[at] = even_y[k];
      pairs->odd_x[at] = odd_x[k];
      pairs->odd_y[at] = odd_y[k];
      pairs->ax[at] = ax[k];
      pairs->ay[at] = ay[k];
      pairs->bx[at] = bx[k];
      pairs->by[at] = by[k];
    }
    return count;
  }

 private:
  Eigen::Matrix2f linear_, inverse_;
  Eigen::Vector2f perspective_;
  Eigen::Matrix<float, 2, LocalMapping::kNumMonomials> w_;
  Eigen::Vector2f center_;
  float x1_, y1_, reach_;
};

// The number of pairs is truncated to a multiple of the vector size.
void MakePairs(const ImageSize& size, const SymmetrySamples& samples,
               const SymmetryMask& mask, const LocalMapping& start,
               Pairs* pairs) {
  const PairMaker maker(size, samples.window_px, start);
  const size_t num_samples = samples.x.size();
  pairs->Resize(num_samples);
  size_t count = 0;
  for (size_t i = 0; i < num_samples; i += kLanes) {
    const size_t num_lanes = std::min<size_t>(kLanes, num_samples - i);
    FloatLanes dx = {}, dy = {};
    std::memcpy(&dx, &samples.x[i], num_lanes * sizeof(float));
    std::memcpy(&dy, &samples.y[i], num_lanes * sizeof(float));
    count +=
        maker.Make(dx, dy, static_cast<int>(num_lanes), mask, count, pairs);
  }
  pairs->Resize(count - count % kLanes);
}

template <int N>
struct System {
  ParameterMatrix<N> hessian = ParameterMatrix<N>::Zero();
  ParameterVector<N> gradient = ParameterVector<N>::Zero();
  double cost = 0;
  double sum = 0, sum_squares = 0;  // sums over sampled values
  int count = 0;
};

// Positions of sample pairs in the patch, and intermediate terms of the
// Jacobian.
struct MirroredPositions {
  FloatLanes ax, ay, bx, by;
  FloatLanes nx, ny;  // A s
  FloatLanes q, r;    // 1 / (1 + h s), 1 / (1 - h s)
  FloatLanes u, v;
};

template <int N>
class Problem {
 public:
  Problem(const SymmetryPatch& patch, const Pairs& pairs, bool inverts_colors)
      : patch_(patch),
        pairs_(pairs),
        reflection_(patch.ComputeReflection(inverts_colors)) {}

  System<N> Evaluate(const LocalMapping& mapping) const {
    const Parameters parameters = TransformToPatch(mapping);
    System<N> system;
    for (const std::vector<float>& channel : patch_.channels()) {
      const float twice_middle =
          reflection_.has_middle ? MeanSum(channel.data(), parameters) : 0.f;
      Accumulate(channel.data(), parameters, twice_middle, &system);
    }
    return system;
  }

 private:
  // The parameters of a LocalMapping in upsampled pixels.
  struct Parameters {
    float a00, a01, a10, a11, h0, h1, cx, cy;
  };
  Parameters TransformToPatch(const LocalMapping& m) const {
    const Eigen::Matrix2f a = kScale * m.linear.cast<float>();
    const Eigen::Vector2f c = patch_.FromPixel(m.center).cast<float>();
    const Eigen::Vector2f h = m.perspective.cast<float>();
    return {a(0, 0), a(0, 1), a(1, 0), a(1, 1), h.x(), h.y(), c.x(), c.y()};
  }

  // Clamps positions to the patch, because optimizing all eight parameters may
  // move samples outside.
  FloatLanes Clamped(FloatLanes x) const {
    const float last = static_cast<float>(patch_.side() - 2);
    for (int k = 0; k < kLanes; ++k) x[k] = std::clamp(x[k], 0.f, last);
    return x;
  }

  MirroredPositions CollectFeaturePositions(const Parameters& p,
                                            size_t i) const {
    MirroredPositions at;
    if constexpr (N == 2) {
      at.ax = p.cx + LoadLanes(&pairs_.ax[i]);
      at.ay = p.cy + LoadLanes(&pairs_.ay[i]);
      at.bx = p.cx + LoadLanes(&pairs_.bx[i]);
      at.by = p.cy + LoadLanes(&pairs_.by[i]);
      return at;
    }
    at.u = LoadLanes(&pairs_.u[i]);
    at.v = LoadLanes(&pairs_.v[i]);
    const FloatLanes d = p.h0 * at.u + p.h1 * at.v;
    at.nx = p.a00 * at.u + p.a01 * at.v;
    at.ny = p.a10 * at.u + p.a11 * at.v;
    at.q = 1 / (1 + d);
    at.r = 1 / (1 - d);
    const FloatLanes odd_x = LoadLanes(&pairs_.odd_x[i]);
    const FloatLanes odd_y = LoadLanes(&pairs_.odd_y[i]);
    const FloatLanes mx = p.cx + LoadLanes(&pairs_.even_x[i]);
    const FloatLanes my = p.cy + LoadLanes(&pairs_.even_y[i]);
    at.ax = Clamped(mx + (at.nx * at.q + odd_x));
    at.ay = Clamped(my + (at.ny * at.q + odd_y));
    at.bx = Clamped(mx - (at.nx * at.r + odd_x));
    at.by = Clamped(my - (at.ny * at.r + odd_y));
    return at;
  }

  float MeanSum(const float* channel, const Parameters& p) const {
    FloatLanes sum = {};
    for (size_t i = 0; i < pairs_.size(); i += kLanes) {
      const MirroredPositions at = CollectFeaturePositions(p, i);
      sum += Bilinear(channel, patch_.side(), 0, at.ax, at.ay).value +
             Bilinear(channel, patch_.side(), 0, at.bx, at.by).value;
    }
    return SumLanes(sum) / static_cast<float>(pairs_.size());
  }

  void Accumulate(const float* channel, const Parameters& p, float twice_middle,
                  System<N>* system) const {
    FloatLanes h[N * (N + 1) / 2] = {}, g[N] = {};
    FloatLanes cost = {}, sum = {}, sum_squares = {};
    const float sign = reflection_.sign;
    for (size_t i = 0; i < pairs_.size(); i += kLanes) {
      const MirroredPositions at = CollectFeaturePositions(p, i);
      const SampledLanes a = Bilinear(channel, patch_.side(), 0, at.ax, at.ay);
      SampledLanes b = Bilinear(channel, patch_.side(), 0, at.bx, at.by);
      const FloatLanes residual = a.value - sign * b.value - twice_middle;
      b.dx *= sign;
      b.dy *= sign;
      FloatLanes j[N];
      j[0] = kScale * (a.dx - b.dx);
      j[1] = kScale * (a.dy - b.dy);
      if constexpr (N == 8) AddHomography(at, a, b, j);
      for (int row = 0, k = 0; row < N; ++row) {
        for (int column = 0; column <= row; ++column, ++k)
          h[k] += j[row] * j[column];
        g[row] += j[row] * residual;
      }
      cost += residual * residual;
      sum += a.value;
      sum_squares += a.value * a.value;
    }
    for (int row = 0, k = 0; row < N; ++row) {
      for (int column = 0; column <= row; ++column, ++k) {
        system->hessian(row, column) += SumLanes(h[k]);
        if (column < row) system->hessian(column, row) += SumLanes(h[k]);
      }
      system->gradient[row] += SumLanes(g[row]);
    }
    system->cost += SumLanes(cost);
    system->sum += SumLanes(sum);
    system->sum_squares += SumLanes(sum_squares);
    system->count += static_cast<int>(pairs_.size());
  }

  // d x(+-s) / d h = -A s u / (1 +- h s)^2, d x(+-s) / d A = +-u / (1 +- h s).
  static void AddHomography(const MirroredPositions& at, const SampledLanes& a,
                            const SampledLanes& b, FloatLanes* j) {
    const FloatLanes J_h = (b.dx * at.nx + b.dy * at.ny) * at.r * at.r -
                           (a.dx * at.nx + a.dy * at.ny) * at.q * at.q;
    const FloatLanes by_x = kScale * (a.dx * at.q + b.dx * at.r);
    const FloatLanes by_y = kScale * (a.dy * at.q + b.dy * at.r);
    j[2] = J_h * at.u;
    j[3] = J_h * at.v;
    j[4] = by_x * at.u;
    j[5] = by_x * at.v;
    j[6] = by_y * at.u;
    j[7] = by_y * at.v;
  }

  const SymmetryPatch& patch_;
  const Pairs& pairs_;
  SymmetryPatch::Reflection reflection_;
};

template <int N>
LocalMapping MapToPoints(LocalMapping mapping,
                         const ParameterVector<N>& step_float) {
  const Eigen::Matrix<double, N, 1> step = step_float.template cast<double>();
  mapping.center += step.template head<2>();
  if constexpr (N == 8) {
    mapping.perspective += step.template segment<2>(2);
    mapping.linear.row(0) += step.template segment<2>(4).transpose();
    mapping.linear.row(1) += step.template segment<2>(6).transpose();
  }
  return mapping;
}

// Levenberg-Marquardt. Returns false if the centre moves by more than
// max_move_px; otherwise the mapping and the system evaluated there.
// Convergence is superlinear, so the error after a step below kConvergedPx is
// negligible.
template <int N>
bool Minimize(const Problem<N>& problem, double max_move_px,
              LocalMapping* mapping, System<N>* system) {
  constexpr int kMaxIterations = 12;
  constexpr double kConvergedPx = 2e-3;
  const Eigen::Vector2d start = mapping->center;
  float lambda = N == 2 ? 0 : 1e-3f;
  *system = problem.Evaluate(*mapping);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    ParameterMatrix<N> damped = system->hessian;
    constexpr float kFloor = 1e-6f;  // times the largest diagonal element
    damped.diagonal() *= 1 + lambda;
    damped.diagonal().array() += kFloor * damped.diagonal().maxCoeff();
    const ParameterVector<N> step = -damped.ldlt().solve(system->gradient);
    if (!step.allFinite()) return false;
    const LocalMapping candidate = MapToPoints<N>(*mapping, step);
    if ((candidate.center - start).norm() > max_move_px) return false;
    const double moved_px = (candidate.center - mapping->center).norm();
    const System<N> next = problem.Evaluate(candidate);
    if (next.cost <= system->cost) {
      *mapping = candidate;
      *system = next;
      lambda /= 4;
    } else {
      lambda = std::max(8 * lambda, 1e-3f);
    }
    if (moved_px < kConvergedPx) break;
  }
  return true;
}

// Returns the standard deviation of the centre along its less certain
// direction, from the covariance s^2 H^-1. s^2 is the mean squared difference,
// but at most 4 times its expectation for the given noise, because asymmetry
// contributes to it, too. The noise of a pixel affects all its samples equally,
// so they count as one. Gradients due to noise contain no information about the
// centre and are subtracted from H. Both factors were measured with white
// noise.
template <int N>
double ComputeStdDevPx(const System<N>& system, int samples_per_pixel,
                       double noise) {
  constexpr double kNoiseDifferences = 1.33, kNoiseGradients = 2.9;
  constexpr double kRounding = 1 / 12.0;
  const double s2 =
      std::min(system.cost / system.count,
               4 * kNoiseDifferences * (noise * noise + kRounding));
  Eigen::Matrix<double, N, N> hessian = system.hessian.template cast<double>();
  hessian.diagonal().template head<2>().array() -=
      kNoiseGradients * s2 * system.count;
  const Eigen::LLT<Eigen::Matrix<double, N, N>> llt(hessian);
  if (llt.info() != Eigen::Success) return INFINITY;
  const Eigen::Matrix2d inverse =
      llt.solve(Eigen::Matrix<double, N, 2>::Identity()).template topRows<2>();
  const double largest =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(inverse).eigenvalues()[1];
  return std::sqrt(samples_per_pixel * s2 * largest);
}

template <int N>
void Refine(const SymmetryPatch& patch, const Pairs& pairs,
            int samples_per_pixel, const SymmetryOptions& options,
            WindowFit* result) {
  const Problem<N> problem(patch, pairs, options.inverts_colors);
  System<N> system;
  if (!Minimize<N>(problem, options.max_move_px, &result->mapping, &system))
    return;
  const double n = system.count, mean = system.sum / n;
  result->is_converged = true;
  result->rms = std::sqrt(system.cost / n);
  result->contrast =
      std::sqrt(std::max(0.0, system.sum_squares / n - mean * mean));
  result->stddev_px = ComputeStdDevPx(system, samples_per_pixel, options.noise);
}

}  // namespace

SymmetrySamples MakeSymmetrySamples(int window_px, int samples_per_pixel) {
  SymmetrySamples samples;
  samples.window_px = window_px;
  samples.per_pixel = samples_per_pixel;
  std::mt19937 engine(1);
  const auto uniform = [&engine] {
    return static_cast<float>(engine() >> 8) * 0x1p-24f - 0.5f;
  };
  // Half of the window; the other half contains the mirrored samples.
  const int half = window_px / 2;
  for (int k = 0; k < samples_per_pixel; ++k) {
    for (int y = 0; y <= half; ++y) {
      for (int x = -half; x <= half; ++x) {
        if (y == 0 && x < 0) continue;
        samples.x.push_back(static_cast<float>(x) + uniform());
        samples.y.push_back(static_cast<float>(y) + uniform());
      }
    }
  }
  return samples;
}

WindowFit RefineSymmetry(const GreyImage& image, const SymmetrySamples& samples,
                         const SymmetryMask& mask, const LocalMapping& start,
                         const SymmetryOptions& options) {
  WindowFit result;
  result.mapping = start;
  // Reused for the next feature, to avoid zero-initialization.
  thread_local Pairs pairs;
  MakePairs(image.size, samples, mask, start, &pairs);
  constexpr size_t kMaxSamplesPerPair = 7;  // at least 1/7 of the window (30 of
                                            // 220 pixels)
  if (pairs.size() * kMaxSamplesPerPair < samples.x.size()) return result;
  // One more pixel for the fraction of the start position, one for
  // interpolation.
  const int reach_px = samples.window_px / 2 +
                       static_cast<int>(kWindowMarginPx + options.max_move_px) +
                       2;
  const SymmetryPatch patch(image, options.refinement, start.center.cast<int>(),
                            reach_px);
  const auto refine = options.center_only ? Refine<2> : Refine<8>;
  refine(patch, pairs, samples.per_pixel, options, &result);
  return result;
}

}  // namespace raygrid
