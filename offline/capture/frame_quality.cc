#include "capture/frame_quality.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

constexpr int kMaxMeasuredFeatures = 48;  // maximum per image
constexpr double kMinHalfPx = 2.5, kMaxHalfPx = 6;
constexpr double kMinContrast = 15;  // grey levels

// Interpolates the grey level between pixels; nullopt outside the image.
std::optional<double> InterpolateGreyLevel(const ImageSize& size,
                                           const std::vector<float>& levels,
                                           const Eigen::Vector2d& pixel) {
  const int x = static_cast<int>(std::floor(pixel.x()));
  const int y = static_cast<int>(std::floor(pixel.y()));
  if (x < 0 || y < 0 || x + 1 >= size.width || y + 1 >= size.height)
    return std::nullopt;
  const double right = pixel.x() - x, down = pixel.y() - y;
  const float* const at = &levels[static_cast<size_t>(y) * size.width + x];
  const float* const below = at + size.width;
  return (1 - down) * ((1 - right) * at[0] + right * at[1]) +
         down * ((1 - right) * below[0] + right * below[1]);
}

// Measured properties of an edge in an image.
struct MeasuredEdge {
  Eigen::Vector2d normal;
  double step = 0;  // grey-level difference from 1 px before to 1 px after it
  double low = 0, high = 0;
  double spread_px = 0;
};

// Measures the profile across an edge near at_px.
std::optional<MeasuredEdge> MeasureEdge(const ImageSize& size,
                                        const std::vector<float>& levels,
                                        const Eigen::Vector2d& at_px,
                                        const Eigen::Vector2d& normal,
                                        double half_px) {
  constexpr int kStepsPerPx = 2;
  const int half = static_cast<int>(half_px * kStepsPerPx);
  std::vector<double> profile;
  for (int k = -half; k <= half; ++k) {
    const auto level =
        InterpolateGreyLevel(size, levels, at_px + normal * k / kStepsPerPx);
    if (!level) return std::nullopt;
    profile.push_back(*level);
  }
  MeasuredEdge edge;
  edge.normal = normal;
  edge.low = *std::min_element(profile.begin(), profile.end());
  edge.high = *std::max_element(profile.begin(), profile.end());
  if (edge.high - edge.low < kMinContrast) return std::nullopt;
  // Uses the maximum, because the feature position may be wrong by a pixel.
  for (size_t k = 2 * kStepsPerPx; k < profile.size(); ++k)
    edge.step = std::max(edge.step,
                         std::abs(profile[k] - profile[k - 2 * kStepsPerPx]));
  return edge;
}

// Returns the standard deviation, in pixels, of a Gaussian blur from the
// fraction of a step within 1 px on both sides: part = erf(1 / (sqrt(2)
// deviation)).
double ComputeSigmaFromStep(double step_fraction) {
  double low = 0.05, high = 20;
  for (int halving = 0; halving < 30; ++halving) {
    const double center = (low + high) / 2;
    (std::erf(M_SQRT1_2 / center) > step_fraction ? low : high) = center;
  }
  return low;
}

// Fits the blur covariance S with n^T S n = spread^2 for edge normals n,
// robustly.
Eigen::Matrix2d FitSpreadCovariance(std::vector<MeasuredEdge> edges) {
  Eigen::Vector3d s = Eigen::Vector3d::Zero();  // xx, xy, yy
  for (int round = 0; round < 3; ++round) {
    Eigen::Matrix3d h = 1e-6 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    std::vector<double> errors;
    const auto row = [](const MeasuredEdge& edge) {
      const Eigen::Vector2d& n = edge.normal;
      return Eigen::Vector3d(n.x() * n.x(), 2 * n.x() * n.y(), n.y() * n.y());
    };
    for (const MeasuredEdge& edge : edges) {
      h += row(edge) * row(edge).transpose();
      b += row(edge) * edge.spread_px * edge.spread_px;
    }
    s = h.ldlt().solve(b);
    for (const MeasuredEdge& edge : edges)
      errors.push_back(
          std::abs(row(edge).dot(s) - edge.spread_px * edge.spread_px));
    constexpr double kMaxErrorRatio = 4;
    const double most = kMaxErrorRatio * Quantile(errors, 0.5) + 1e-9;
    std::vector<MeasuredEdge> near;
    for (size_t k = 0; k < edges.size(); ++k)
      if (errors[k] <= most) near.push_back(edges[k]);
    edges = std::move(near);
  }
  Eigen::Matrix2d matrix;
  matrix << s[0], s[1], s[1], s[2];
  return matrix;
}

}  // namespace

// Whether the nominal appearance is uniform on each side of the edge within the
// profile, also along the edge.
bool QualityMeter::IsStep(const Eigen::Vector2d& at, const Edge& edge) const {
  for (const double nearness : {0.85, 1.0, 1.15})
    for (const double step_fraction : {0.1, 0.4, 0.7, 1.0}) {
      const auto is_black = [&](double along, double side) {
        return appearance_.IsBlack(at + along * edge.center +
                                   side * edge.across);
      };
      if (is_black(nearness, step_fraction) != is_black(1, 1) ||
          is_black(nearness, -step_fraction) != is_black(1, -1) ||
          is_black(1, 1) == is_black(1, -1))
        return false;
    }
  return true;
}

QualityMeter::QualityMeter(const Board& board)
    : board_(board), appearance_(board), edges_(board.num_points()) {
  constexpr int kDirections = 144;
  constexpr double kRadii[] = {0.42, 0.3};                   // squares
  constexpr double kHalfLengths[] = {0.3, 0.2, 0.12, 0.07};  // squares
  const std::vector<Eigen::Vector3d> points = board.NominalPoints();
  for (int i = 0; i < board.num_points(); ++i) {
    const Eigen::Vector2d at = points[i].head<2>();
    const auto along = [](double angle) {
      return Eigen::Vector2d(std::cos(angle), std::sin(angle));
    };
    for (int k = 0; k < kDirections; ++k) {
      const double angle = 2 * M_PI * k / kDirections;
      const double next = 2 * M_PI * (k + 1) / kDirections;
      const double radius_m = kRadii[0] * board.square_m;
      if (appearance_.IsBlack(at + radius_m * along(angle - 0.01)) ==
          appearance_.IsBlack(at + radius_m * along(next - 0.01)))
        continue;
      // Locates the edge by bisection.
      double low = angle - 0.01, high = next - 0.01;
      const bool first = appearance_.IsBlack(at + radius_m * along(low));
      for (int halving = 0; halving < 12; ++halving) {
        const double center = (low + high) / 2;
        (appearance_.IsBlack(at + radius_m * along(center)) == first ? low
                                                                     : high) =
            center;
      }
      const Eigen::Vector2d direction = along((low + high) / 2);
      const Eigen::Vector2d across(-direction.y(), direction.x());
      const auto add_longest_edge = [&] {
        for (const double radius : kRadii)
          for (const double half : kHalfLengths) {
            const Edge edge = {radius * board.square_m * direction,
                               half * board.square_m * across};
            if (!IsStep(at, edge)) continue;
            edges_[i].push_back(edge);
            return;
          }
      };
      add_longest_edge();
    }
  }
}

FrameQuality QualityMeter::Measure(const ImageSize& size,
                                   const std::vector<float>& levels,
                                   const std::vector<Feature>& features) const {
  std::vector<const Feature*> at(board_.num_points(), nullptr);
  for (const Feature& feature : features)
    at[board_.PointIndex(feature.column, feature.row)] = &feature;
  const std::vector<Eigen::Vector3d> points = board_.NominalPoints();
  // Local image scale, from the neighbours of a feature.
  const auto slope = [&](const Feature& feature, int right,
                         int down) -> std::optional<Eigen::Vector2d> {
    const auto place = [&](int side) -> int {
      const int column = feature.column + side * right;
      const int row = feature.row + side * down;
      const bool is_on = column >= 0 && row >= 0 && column < board_.columns &&
                         row < board_.rows;
      const int index = is_on ? board_.PointIndex(column, row) : -1;
      return is_on && at[index] ? index : -1;
    };
    const int own = board_.PointIndex(feature.column, feature.row);
    const int before = place(-1) < 0 ? own : place(-1);
    const int behind = place(1) < 0 ? own : place(1);
    if (before == behind) return std::nullopt;
    return (at[behind]->pixel - at[before]->pixel) /
           (points[behind] - points[before]).norm();
  };
  std::vector<MeasuredEdge> seen;
  const size_t count = std::min<size_t>(features.size(), kMaxMeasuredFeatures);
  for (size_t k = 0; k < count; ++k) {
    const Feature& feature = features[k * features.size() / count];
    const auto J_x = slope(feature, 1, 0), J_y = slope(feature, 0, 1);
    if (!J_x || !J_y) continue;
    Eigen::Matrix2d image_from_board;
    image_from_board << *J_x, *J_y;
    for (const Edge& edge :
         edges_[board_.PointIndex(feature.column, feature.row)]) {
      const Eigen::Vector2d along = image_from_board * edge.center;
      const Eigen::Vector2d normal =
          Eigen::Vector2d(-along.y(), along.x()).normalized();
      const double half_px = std::min(
          kMaxHalfPx, std::abs(normal.dot(image_from_board * edge.across)));
      if (!(half_px >= kMinHalfPx)) continue;
      if (const auto found =
              MeasureEdge(size, levels, feature.pixel + along, normal, half_px))
        seen.push_back(*found);
    }
  }
  FrameQuality quality;
  constexpr size_t kFewest = 6;
  if (seen.size() < kFewest) return quality;
  std::vector<double> white_levels, black_levels;
  double clipped = 0;
  constexpr double kFull = 254;
  for (const MeasuredEdge& edge : seen) {
    white_levels.push_back(edge.high);
    black_levels.push_back(edge.low);
    clipped += edge.high >= kFull;
  }
  // Quantiles, because near other edges a profile does not attain both levels.
  constexpr double kWhiteQuantile = 0.75;
  quality.white = Quantile(white_levels, kWhiteQuantile);
  quality.black = Quantile(black_levels, 1 - kWhiteQuantile);
  quality.clipped = clipped / static_cast<double>(seen.size());
  for (MeasuredEdge& edge : seen)
    edge.spread_px =
        ComputeSigmaFromStep(edge.step / (quality.white - quality.black));
  const Eigen::Vector2d squares =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(FitSpreadCovariance(seen))
          .eigenvalues();
  quality.min_spread_px = std::sqrt(std::max(0.0, squares[0]));
  quality.max_spread_px = std::sqrt(std::max(0.0, squares[1]));
  return quality;
}

}  // namespace raygrid
