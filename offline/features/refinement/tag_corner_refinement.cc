#include "features/refinement/tag_corner_refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "appearance/board_appearance.h"
#include "features/refinement/blurred_ink.h"

namespace raygrid {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Adds the black cells of a tag rotated clockwise by multiples of 90 degrees.
// Adjacent cells of a row are merged into one rectangle.
void AddCells(const PlacedMarker& tag, int quarter_turns,
              const Vector2d& corner_m, double square_m,
              std::vector<InkRectangle>* ink) {
  const int n = tag.bits.size;
  const auto is_black = [&](int column, int row) {
    for (int k = 0; k < quarter_turns; ++k) {
      const int turned = n - 1 - column;
      column = row;
      row = turned;
    }
    return tag.bits.at(column, row);
  };
  const double cell = tag.cell_m / square_m;
  const Vector2d origin = (tag.corner - corner_m) / square_m;
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      if (!is_black(column, row)) continue;
      const int first = column;
      while (column + 1 < n && is_black(column + 1, row)) ++column;
      ink->push_back({origin.x() + first * cell, origin.y() + row * cell,
                      origin.x() + (column + 1) * cell,
                      origin.y() + (row + 1) * cell});
    }
  }
}

// A pixel of the window: offset from its centre in half windows, board offset
// in squares, and grey level.
struct WindowPixel {
  double x, y;
  Vector2d place;
  double level;
};

// Returns the board offset that is projected to a pixel.
Vector2d ComputeBoardOffset(const LocalMapping& mapping,
                            const Matrix2d& inverse, const Vector2d& pixel) {
  Vector2d offset = inverse * (pixel - mapping.center);
  constexpr int kSteps = 4;
  for (int k = 0; k < kSteps; ++k)
    offset -= inverse * (mapping(offset) - pixel);
  return offset;
}

enum CornerParameter {
  kCornerX,
  kCornerY,
  kRotationU,
  kRotationV,
  kLogSigma,
  kBlackLevel,
  kWhiteLevel,
  kWhiteByX,
  kWhiteByY,
  kTone,
  kNumCornerParameters
};
using CornerParameters = Eigen::Matrix<double, kNumCornerParameters, 1>;
using CornerHessian =
    Eigen::Matrix<double, kNumCornerParameters, kNumCornerParameters>;

struct CornerSystem {
  CornerHessian hessian = CornerHessian::Zero();
  CornerParameters gradient = CornerParameters::Zero();
  double cost = 0;                  // including priors
  double squares = 0;               // without priors
  double sum = 0, sum_squares = 0;  // sums over grey levels
};

// Standard deviations of the priors.
constexpr double kEdgeRotationStdDevRad = 0.05;  // radians
constexpr double kBlurPx = 0.9, kLogSigmaStdDev = 0.7;
constexpr double kWhiteSlope = 0.1;  // contrasts per half window

// Recorded intensity for light from 0 to 1, and its derivatives.
struct ToneResponse {
  double seen, J_light, J_tone;
};

ToneResponse ApplyTone(double light, double tone) {
  constexpr double kNearlyLinear = 1e-3;
  if (std::fabs(tone) < kNearlyLinear)
    return {light + tone / 2 * light * (1 - light),
            1 + tone / 2 * (1 - 2 * light), light * (1 - light) / 2};
  const double e = std::exp(tone), gain = 1 + (e - 1) * light;
  const double seen = std::log(gain) / tone;
  return {seen, (e - 1) / (tone * gain), (e * light / gain - seen) / tone};
}

class CornerProblem {
 public:
  CornerProblem(const Quadrants& quadrants, const LocalMapping& start,
                std::vector<WindowPixel> samples,
                const TagCornerOptions& options, double tone_stddev)
      : quadrants_(quadrants),
        samples_(std::move(samples)),
        has_known_edges_(options.has_known_edges),
        tone_(options.tone),
        tone_stddev_(tone_stddev),
        prior_scale_(std::max(options.noise * options.noise, 1 / 12.0)) {
    inverse_ = start.linear.inverse();
    const auto turned = [](const Vector2d& a) {
      return Vector2d(-a.y(), a.x());
    };
    rotation_u_ = inverse_ * turned(start.linear.col(0));
    rotation_v_ = inverse_ * turned(start.linear.col(1));
  }

  // Returns the initial values: grey levels by linear least squares, other
  // parameters near their prior means.
  CornerParameters Start() const {
    CornerParameters p = CornerParameters::Zero();
    p[kLogSigma] = std::log(1.5 * kBlurPx);
    p[kTone] = tone_;
    InkBlurrer blurred(quadrants_, GetBlur(p));
    double n = 0, q = 0, qq = 0, l = 0, ql = 0;
    for (const WindowPixel& s : samples_) {
      const double paper = 1 - blurred.At(s.place.x(), s.place.y()).ink;
      n += 1;
      q += paper;
      qq += paper * paper;
      l += s.level;
      ql += paper * s.level;
    }
    const double variance = n * qq - q * q;
    p[kWhiteLevel] = variance > 0 ? (n * ql - q * l) / variance : 0;
    p[kBlackLevel] = (l - p[kWhiteLevel] * q) / n;
    return p;
  }

  CornerSystem Evaluate(const CornerParameters& p) const {
    CornerSystem system;
    InkBlurrer blurred(quadrants_, GetBlur(p));
    for (const WindowPixel& s : samples_) {
      const Vector2d moved = s.place - inverse_ * p.head<2>() -
                             (p[kRotationU] * s.place.x() * rotation_u_ +
                              p[kRotationV] * s.place.y() * rotation_v_);
      const BlurredInk ink = blurred.At(moved.x(), moved.y());
      const double white =
          p[kWhiteLevel] + p[kWhiteByX] * s.x + p[kWhiteByY] * s.y;
      const ToneResponse light =
          ApplyTone(std::clamp(1 - ink.ink, 0.0, 1.0), p[kTone]);
      const double residual = p[kBlackLevel] + white * light.seen - s.level;
      const double J_ink = -white * light.J_light;
      const Vector2d J_board_pose = J_ink * Vector2d(ink.J_u, ink.J_v);
      CornerParameters j;
      j.head<2>() = -inverse_.transpose() * J_board_pose;
      j[kRotationU] = -J_board_pose.dot(rotation_u_) * s.place.x();
      j[kRotationV] = -J_board_pose.dot(rotation_v_) * s.place.y();
      j[kLogSigma] = J_ink * ink.J_log_sigma;
      j[kBlackLevel] = 1;
      j[kWhiteLevel] = light.seen;
      j[kWhiteByX] = light.seen * s.x;
      j[kWhiteByY] = light.seen * s.y;
      j[kTone] = white * light.J_tone;
      system.hessian.selfadjointView<Eigen::Lower>().rankUpdate(j);
      system.gradient += residual * j;
      system.squares += residual * residual;
      system.sum += s.level;
      system.sum_squares += s.level * s.level;
    }
    system.hessian = system.hessian.selfadjointView<Eigen::Lower>();
    system.cost = system.squares;
    AddPriors(p, &system);
    return system;
  }

  size_t size() const { return samples_.size(); }

 private:
  BoardBlur GetBlur(const CornerParameters& p) const {
    const Vector2d J_u = inverse_.row(0), J_v = inverse_.row(1);
    const double sigma = std::exp(p[kLogSigma]);
    return {sigma * J_u.norm(), sigma * J_v.norm(),
            J_u.dot(J_v) / (J_u.norm() * J_v.norm())};
  }

  void AddPriors(const CornerParameters& p, CornerSystem* system) const {
    const auto add = [&](int k, double expected, double deviation) {
      const double weight = prior_scale_ / (deviation * deviation);
      system->hessian(k, k) += weight;
      system->gradient[k] += weight * (p[k] - expected);
      system->cost += weight * std::pow(p[k] - expected, 2);
    };
    constexpr double kFixed = 1e-6;
    const double turn = has_known_edges_ ? kFixed : kEdgeRotationStdDevRad;
    add(kRotationU, 0, turn);
    add(kRotationV, 0, turn);
    add(kLogSigma, std::log(kBlurPx), kLogSigmaStdDev);
    const double slope = kWhiteSlope * std::max(1.0, std::fabs(p[kWhiteLevel]));
    add(kWhiteByX, 0, slope);
    add(kWhiteByY, 0, slope);
    add(kTone, tone_, tone_stddev_);
  }

  const Quadrants& quadrants_;
  std::vector<WindowPixel> samples_;
  bool has_known_edges_;
  double tone_, tone_stddev_;
  double prior_scale_;
  Matrix2d inverse_;
  Vector2d rotation_u_, rotation_v_;  // displacement per radian of edge
                                      // rotation, in squares
};

// Levenberg-Marquardt. Returns false if the corner moves by more than
// max_move_px.
bool MinimizeCorner(const CornerProblem& problem, double max_move_px,
                    CornerParameters* p, CornerSystem* system) {
  constexpr int kMaxIterations = 20;
  constexpr double kConvergedPx = 1e-3;
  const double min_log_sigma = std::log(0.3), max_log_sigma = std::log(6.0);
  double lambda = 1e-3;
  *system = problem.Evaluate(*p);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    CornerHessian damped = system->hessian;
    damped.diagonal() *= 1 + lambda;
    damped.diagonal().array() += 1e-9;
    const CornerParameters step = -damped.ldlt().solve(system->gradient);
    if (!step.allFinite()) return false;
    CornerParameters candidate = *p + step;
    candidate[kLogSigma] =
        std::clamp(candidate[kLogSigma], min_log_sigma, max_log_sigma);
    const CornerSystem next = problem.Evaluate(candidate);
    if (next.cost <= system->cost) {
      *p = candidate;
      *system = next;
      lambda /= 8;
      if (p->head<2>().norm() > max_move_px) return false;
    } else {
      lambda *= 10;
    }
    if (step.head<2>().norm() < kConvergedPx &&
        std::fabs(step[kRotationU]) < 1e-4)
      break;
  }
  return true;
}

// Returns the standard deviation of the corner along its less certain
// direction.
double ComputeCornerStdDevPx(const CornerSystem& system, size_t count,
                             double noise) {
  const double s2 = std::max(
      noise * noise + 1 / 12.0,
      system.squares / static_cast<double>(count - kNumCornerParameters));
  const Eigen::LLT<CornerHessian> llt(system.hessian);
  if (llt.info() != Eigen::Success) return INFINITY;
  const Matrix2d inverse =
      llt.solve(Eigen::Matrix<double, kNumCornerParameters, 2>::Identity())
          .topRows<2>();
  return std::sqrt(
      s2 * Eigen::SelfAdjointEigenSolver<Matrix2d>(inverse).eigenvalues()[1]);
}

}  // namespace

struct TagCornerRefiner::Data {
  explicit Data(const Board& b)
      : board(b),
        tags(BoardAppearance(b).markers()),
        points_m(b.NominalPoints()) {}

  Board board;
  std::vector<PlacedMarker> tags;
  std::vector<Eigen::Vector3d> points_m;

  std::vector<InkRectangle> GetInkAround(int column, int row,
                                         int quarter_turns) const;
  std::vector<WindowPixel> ListPixelsNear(const GreyImage& image, int column,
                                          int row, const LocalMapping& start,
                                          int window_px) const;
  double ComputeTemplateCorrelation(const GreyImage& image, int column, int row,
                                    const LocalMapping& start,
                                    int quarter_turns) const;
  WindowFit Fit(const GreyImage& image, const TagCorner& start,
                const TagCornerOptions& options, double tone_stddev,
                double* tone) const;
};

std::vector<InkRectangle> TagCornerRefiner::Data::GetInkAround(
    int column, int row, int quarter_turns) const {
  const Vector2d corner_m = points_m[board.PointIndex(column, row)].head<2>();
  std::vector<InkRectangle> ink;
  for (int r = row / 2 - 1; r <= row / 2 + 1; ++r)
    for (int c = column / 2 - 1; c <= column / 2 + 1; ++c)
      if (r >= 0 && c >= 0 && r < board.rows / 2 && c < board.columns / 2)
        AddCells(tags[r * (board.columns / 2) + c], quarter_turns, corner_m,
                 board.square_m, &ink);
  return ink;
}

// Returns the pixels near the two edges of the corner: inside up to 0.6 of the
// width of the tag's border, outside up to half of the gap between tags, but at
// most one cell.
std::vector<WindowPixel> TagCornerRefiner::Data::ListPixelsNear(
    const GreyImage& image, int column, int row, const LocalMapping& start,
    int window_px) const {
  constexpr double kBorderFraction = 0.6, kGapFraction = 0.5,
                   kMaxEdgeFraction = 0.8;
  const double cell = tags[0].cell_m / board.square_m;
  const double inwards = kBorderFraction * board.border_cells * cell;
  const double outwards = std::min(kGapFraction * board.spacing_ratio, cell);
  // Signs of the direction towards the inside of the tag.
  const Vector2d inside(column % 2 == 0 ? 1 : -1, row % 2 == 0 ? 1 : -1);
  const Matrix2d inverse = start.linear.inverse();
  const int half = window_px / 2;
  const Eigen::Vector2i middle = start.center.array().round().cast<int>();
  std::vector<WindowPixel> samples;
  for (int y = middle.y() - half; y <= middle.y() + half; ++y) {
    for (int x = middle.x() - half; x <= middle.x() + half; ++x) {
      if (x < 0 || y < 0 || x >= image.size.width || y >= image.size.height)
        continue;
      const Vector2d place = ComputeBoardOffset(start, inverse, Vector2d(x, y));
      const Vector2d in = place.cwiseProduct(inside);
      const double depth = in.minCoeff();
      if (!(depth >= -outwards && depth <= inwards &&
            in.maxCoeff() <= kMaxEdgeFraction))
        continue;
      samples.push_back({(x - middle.x()) / static_cast<double>(half),
                         (y - middle.y()) / static_cast<double>(half), place,
                         image.at(x, y)});
    }
  }
  return samples;
}

// Returns the correlation of the image with the tag's cells near the corner.
double TagCornerRefiner::Data::ComputeTemplateCorrelation(
    const GreyImage& image, int column, int row, const LocalMapping& start,
    int quarter_turns) const {
  const PlacedMarker& tag = tags[row / 2 * (board.columns / 2) + column / 2];
  const int n = tag.bits.size;
  const double cell = tag.cell_m / board.square_m;
  const Vector2d corner_m = points_m[board.PointIndex(column, row)].head<2>();
  std::vector<InkRectangle> black;
  AddCells(tag, quarter_turns, corner_m, board.square_m, &black);
  const Vector2d origin = (tag.corner - corner_m) / board.square_m;
  double count = 0, p = 0, pp = 0, q = 0, qq = 0, pq = 0;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const Vector2d place = origin + cell * Vector2d(i + 0.5, j + 0.5);
      constexpr double kNear = 0.6;
      if (place.cwiseAbs().maxCoeff() > kNear) continue;
      const Eigen::Vector2i at = start(place).array().round().cast<int>();
      if (at.minCoeff() < 0 || at.x() >= image.size.width ||
          at.y() >= image.size.height)
        continue;
      const bool is_white =
          std::none_of(black.begin(), black.end(), [&](const InkRectangle& r) {
            return place.x() > r.u0 && place.x() < r.u1 && place.y() > r.v0 &&
                   place.y() < r.v1;
          });
      const double level = image.at(at.x(), at.y());
      count += 1;
      p += level;
      pp += level * level;
      q += is_white;
      qq += is_white;
      pq += is_white * level;
    }
  }
  const double variances = (count * pp - p * p) * (count * qq - q * q);
  return variances > 0 ? (count * pq - p * q) / std::sqrt(variances) : -1;
}

TagCornerRefiner::TagCornerRefiner(const Board& board)
    : data_(std::make_unique<Data>(board)) {}
TagCornerRefiner::~TagCornerRefiner() = default;

// Also estimates the tone, unless tone_stddev is negligible.
WindowFit TagCornerRefiner::Data::Fit(const GreyImage& image,
                                      const TagCorner& start,
                                      const TagCornerOptions& options,
                                      double tone_stddev, double* tone) const {
  const auto& [column, row, mapping] = start;
  WindowFit fit;
  fit.mapping = mapping;
  std::vector<WindowPixel> pixels =
      ListPixelsNear(image, column, row, mapping, options.window_px);
  constexpr size_t kMinPixels = 60;
  if (pixels.size() < kMinPixels) return fit;
  int turns = 0;
  double most = -2;
  for (int k = 0; k < 4; ++k) {
    const double likeness =
        ComputeTemplateCorrelation(image, column, row, mapping, k);
    if (likeness <= most) continue;
    most = likeness;
    turns = k;
  }
  const Quadrants quadrants(GetInkAround(column, row, turns),
                            options.window_px / mapping.CircleWidthPx());
  const CornerProblem problem(quadrants, mapping, std::move(pixels), options,
                              tone_stddev);
  CornerParameters p = problem.Start();
  CornerSystem system;
  if (!MinimizeCorner(problem, options.max_move_px, &p, &system)) return fit;
  const double n = static_cast<double>(problem.size());
  const double mean = system.sum / n;
  fit.is_converged = p[kWhiteLevel] > 0;
  fit.mapping.center += p.head<2>();
  fit.rms = std::sqrt(system.squares / n);
  fit.contrast = std::sqrt(std::max(0.0, system.sum_squares / n - mean * mean));
  fit.stddev_px = ComputeCornerStdDevPx(system, problem.size(), options.noise);
  *tone = p[kTone];
  return fit;
}

WindowFit TagCornerRefiner::Refine(const GreyImage& image,
                                   const TagCorner& start,
                                   const TagCornerOptions& options) const {
  constexpr double kFixedTone = 1e-6;
  double tone;
  return data_->Fit(image, start, options, kFixedTone, &tone);
}

double TagCornerRefiner::EstimateTone(const GreyImage& image,
                                      const std::vector<TagCorner>& corners,
                                      TagCornerOptions options) const {
  constexpr size_t kMaxCorners = 80, kMinCorners = 8;
  constexpr double kToneStdDev = 1;
  options.tone = 0;
  std::vector<double> tones;
  const size_t stride = 1 + corners.size() / kMaxCorners;
  for (size_t i = 0; i < corners.size(); i += stride) {
    double tone = 0;
    const WindowFit fit =
        data_->Fit(image, corners[i], options, kToneStdDev, &tone);
    if (fit.is_converged) tones.push_back(tone);
  }
  if (tones.size() < kMinCorners) return 0;
  const auto middle = tones.begin() + static_cast<ptrdiff_t>(tones.size() / 2);
  std::nth_element(tones.begin(), middle, tones.end());
  return *middle;
}

}  // namespace raygrid
