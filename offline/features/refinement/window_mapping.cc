#include "features/refinement/window_mapping.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

constexpr int kWindowRadius = 3;  // distance of the neighbours, in squares
constexpr int kWindowDegree = 3;
constexpr double kMaxNegligibleSagittaPx = 0.25;  // negligible
// Error of a mapping fitted within three squares, as fractions of its curvature
// in the window, and of its difference from a mapping fitted within two
// squares. Measured with lenses up to 190 degrees.
constexpr double kSagittaFraction = 0.07, kDifferenceFraction = 0.1;
// Error of the mapping of the lens model, as fractions of its curvature and of
// its residuals at the neighbours.
constexpr double kCameraSagittaFraction = 0.02, kErrorFraction = 0.15;

// Returns the maximum difference of the curvatures of two mappings: of the
// displacement of the midpoint of two opposite points at radius_px from the
// feature. Symmetry refinement cannot observe these even terms.
double ComputeSagittaPx(const LocalMapping& a, const LocalMapping& b,
                        const LocalMapping& scale, double radius_px) {
  constexpr int kDirections = 8;
  const Eigen::Matrix2d inverse = scale.linear.inverse();
  const auto even_part = [](const LocalMapping& m, const Eigen::Vector2d& s) {
    return Eigen::Vector2d((m(s) + m(-s)) / 2 - m.center);
  };
  double most = 0;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = k * M_PI / kDirections;
    const Eigen::Vector2d s =
        inverse *
        (radius_px * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    most = std::max(most, (even_part(a, s) - even_part(b, s)).norm());
  }
  return most;
}

double ComputeSagittaPx(const LocalMapping& mapping, double radius_px) {
  return ComputeSagittaPx(mapping, LocalMapping(), mapping, radius_px);
}

// Returns the RMS residual of a mapping after removing the mean.
double ComputeScatterPx(const LocalMapping& mapping,
                        const std::vector<Correspondence>& around) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double sum2 = 0;
  for (const Correspondence& c : around) {
    const Eigen::Vector2d error = mapping(c.offset) - c.pixel;
    sum += error;
    sum2 += error.squaredNorm();
  }
  const double count = static_cast<double>(around.size());
  return std::sqrt(std::max(0.0, (sum2 - sum.squaredNorm() / count) / count));
}

}  // namespace

const std::optional<LatticeCamera>& WindowMappings::Lens() {
  // Tag corners of an AprilGrid are not evenly spaced.
  if (!is_camera_fitted_ && !board_.IsTagGrid())
    lens_ = LatticeCamera::Fit(lattice_.Features(), size_);
  is_camera_fitted_ = true;
  return lens_;
}

std::optional<WindowMapping> WindowMappings::PredictWithCamera(int column,
                                                               int row) {
  if (!Lens()) return std::nullopt;
  const auto seen = Lens()->Around(Eigen::Vector2d(column, row));
  const auto around = lattice_.Around(column, row, 1, true);
  constexpr size_t kMinAround = 3;
  if (!seen || around.size() < kMinAround) return std::nullopt;
  return WindowMapping{
      *seen, kWindowDegree,
      std::max(kCameraSagittaFraction * ComputeSagittaPx(*seen, window_px_ / 3),
               kErrorFraction * ComputeScatterPx(*seen, around))};
}

WindowMapping WindowMappings::At(int column, int row) {
  WindowMapping window;
  window.degree =
      FitLocalMapping(lattice_.Around(column, row, kWindowRadius, true),
                      kWindowDegree, &window.mapping);
  // A mapping without curvature is optimized together with the centre.
  if (window.degree <= 1) return window;
  const double radius_px = window_px_ / 3;
  const double sagitta_px = ComputeSagittaPx(window.mapping, radius_px);
  if (sagitta_px < kMaxNegligibleSagittaPx) return window;
  LocalMapping nearer;
  const bool is_known =
      FitLocalMapping(lattice_.Around(column, row, kWindowRadius - 1, true),
                      kWindowDegree, &nearer) > 0;
  const double difference_px =
      is_known
          ? ComputeSagittaPx(window.mapping, nearer, window.mapping, radius_px)
          : sagitta_px;
  window.sagitta_stddev_px = std::max(kSagittaFraction * sagitta_px,
                                      kDifferenceFraction * difference_px);
  const auto camera_window = PredictWithCamera(column, row);
  if (camera_window &&
      camera_window->sagitta_stddev_px < window.sagitta_stddev_px)
    return *camera_window;
  return window;
}

}  // namespace raygrid
