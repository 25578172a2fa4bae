#include "exchange/ocam_camera.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "camera/model_fitting.h"

namespace raygrid {
namespace {

double EvaluatePolynomial(const std::vector<double>& polynomial, double x) {
  double value = 0;
  for (size_t k = polynomial.size(); k-- > 0;)
    value = value * x + polynomial[k];
  return value;
}

double EvaluateDerivative(const std::vector<double>& polynomial, double x) {
  double slope = 0;
  for (size_t k = polynomial.size(); k-- > 1;)
    slope = slope * x + static_cast<double>(k) * polynomial[k];
  return slope;
}

double ComputeAngle(const Eigen::Vector3d& direction) {
  return std::atan2(direction.head<2>().norm(), direction.z());
}

// Fits a polynomial by least squares, without the linear term if OCamCalib has
// none there. x is scaled to improve the conditioning.
std::vector<double> FitPolynomial(const std::vector<double>& x,
                                  const std::vector<double>& y, int degree,
                                  bool has_slope) {
  double scale = 0;
  for (const double each : x) scale = std::max(scale, std::abs(each));
  std::vector<int> powers = {0};
  for (int k = has_slope ? 1 : 2; k <= degree; ++k) powers.push_back(k);
  const auto rows = static_cast<Eigen::Index>(x.size()),
             columns = static_cast<Eigen::Index>(powers.size());
  Eigen::MatrixXd equations(rows, columns);
  Eigen::VectorXd right(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    for (Eigen::Index k = 0; k < columns; ++k)
      equations(i, k) = std::pow(x[i] / scale, powers[k]);
    right[i] = y[i];
  }
  const Eigen::VectorXd solution = equations.colPivHouseholderQr().solve(right);
  std::vector<double> polynomial(degree + 1, 0);
  for (Eigen::Index k = 0; k < columns; ++k)
    polynomial[powers[k]] = solution[k] / std::pow(scale, powers[k]);
  return polynomial;
}

struct OcamSample {
  Eigen::Vector2d pixel;
  Eigen::Vector3d ray;
};

// Samples pixels of the valid region and their directions for the fit.
std::vector<OcamSample> SampleCamera(const CameraModel& camera,
                                     const ValidityMask* valid_region) {
  constexpr double kSamplesAcross = 28;
  const Area& area = camera.area();
  const double step_px =
      std::max(1.0, std::max(area.width(), area.height()) / kSamplesAcross);
  std::vector<OcamSample> samples;
  for (double y = area.y0; y <= area.y1; y += step_px)
    for (double x = area.x0; x <= area.x1; x += step_px) {
      const Eigen::Vector2d pixel(x, y);
      if ((valid_region && !valid_region->IsValidAt(pixel)) ||
          !camera.IsInImageCircle(pixel))
        continue;
      if (const auto ray = camera.Unproject(pixel))
        samples.push_back({pixel, ray->normalized()});
    }
  return samples;
}

// Fits the OCamCalib model and a rotation by Levenberg-Marquardt. Parameter
// vector: centre, c, d, e, rotation, and the polynomial without its linear
// term, of radii in units of the longer image side.
class OcamFit {
 public:
  OcamFit(const ImageSize& size, std::vector<OcamSample> samples,
          const FittedModel& near)
      : size_(size), samples_(std::move(samples)), initial_model_(near) {}

  struct FittedPolynomial {
    OcamNumbers numbers;
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
    double rms_px = INFINITY;
  };

  FittedPolynomial Fit(int degree) const {
    constexpr int kRounds = 12;
    constexpr double kTolerance = 1e-6;
    Eigen::VectorXd x = Start(degree);
    Eigen::VectorXd residuals = Residuals(x);
    double damping = 1e-6;
    for (int round = 0; round < kRounds; ++round) {
      const Eigen::MatrixXd jacobian = Jacobian(x, residuals);
      const Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
      const Eigen::VectorXd gradient = jacobian.transpose() * residuals;
      Eigen::MatrixXd damped = normal;
      damped.diagonal() *= 1 + damping;
      const Eigen::VectorXd next = x - damped.ldlt().solve(gradient);
      const Eigen::VectorXd after = Residuals(next);
      const double before_sum = residuals.squaredNorm();
      if (!(after.squaredNorm() < before_sum)) {
        damping = std::max(1e-3, 10 * damping);
        continue;
      }
      x = next;
      residuals = after;
      damping /= 10;
      if (before_sum - residuals.squaredNorm() < kTolerance * before_sum) break;
    }
    FittedPolynomial fitted = {MakeNumbers(x), ComputeRotation(x), 0};
    fitted.rms_px = std::sqrt(residuals.squaredNorm() /
                              static_cast<double>(samples_.size()));
    return fitted;
  }

 private:
  static constexpr int kFirst = 8;  // index of the first polynomial coefficient

  double Scale() const { return std::max(size_.width, size_.height); }

  // Returns the initial values: a polynomial fitted to the directions around
  // the centre of the nearest fisheye model.
  Eigen::VectorXd Start(int degree) const {
    const Eigen::VectorXd lens = initial_model_.model->Parameters();
    std::vector<double> radii, values;
    for (const OcamSample& sample : samples_) {
      const Eigen::Vector3d ray = initial_model_.model_from_camera * sample.ray;
      const double down = (sample.pixel.y() - lens[3]) * lens[0] / lens[1],
                   right = sample.pixel.x() - lens[2];
      const double radius = std::hypot(down, right);
      const double across = ray.head<2>().norm();
      if (!(across > 1e-3)) continue;
      radii.push_back(radius / Scale());
      values.push_back(-ray.z() * radius / across / Scale());
    }
    const std::vector<double> polynomial =
        FitPolynomial(radii, values, degree, false);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(kFirst + degree);
    x.head<3>() << lens[3], lens[2], lens[1] / lens[0];
    x[kFirst] = polynomial[0];
    for (int k = 2; k <= degree; ++k) x[kFirst + k - 1] = polynomial[k];
    return x;
  }

  OcamNumbers MakeNumbers(const Eigen::VectorXd& x) const {
    OcamNumbers numbers = {{}, x[0], x[1], x[2], x[3], x[4]};
    numbers.polynomial.assign(x.size() - kFirst + 1, 0);
    numbers.polynomial[0] = x[kFirst] * Scale();
    for (size_t k = 2; k < numbers.polynomial.size(); ++k)
      numbers.polynomial[k] = x[kFirst + static_cast<Eigen::Index>(k) - 1] /
                              std::pow(Scale(), static_cast<double>(k) - 1);
    return numbers;
  }

  Eigen::Quaterniond ComputeRotation(const Eigen::VectorXd& x) const {
    const Eigen::Vector3d turn = x.segment<3>(5);
    const double angle = turn.norm();
    return (angle > 0
                ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle))
                : Eigen::Quaterniond::Identity()) *
           initial_model_.model_from_camera;
  }

  Eigen::VectorXd Residuals(const Eigen::VectorXd& x) const {
    constexpr double kUnlimitedMarginPx = 1e9, kMissingErrorPx = 100;
    const OcamCamera camera(size_, MakeNumbers(x));
    const Eigen::Quaterniond turn = ComputeRotation(x);
    Eigen::VectorXd residuals(2 * samples_.size());
    for (size_t k = 0; k < samples_.size(); ++k) {
      const auto pixel =
          camera.Project(turn * samples_[k].ray, nullptr, kUnlimitedMarginPx);
      residuals.segment<2>(2 * static_cast<Eigen::Index>(k)) =
          pixel ? Eigen::Vector2d(*pixel - samples_[k].pixel)
                : Eigen::Vector2d(kMissingErrorPx, kMissingErrorPx);
    }
    return residuals;
  }

  Eigen::MatrixXd Jacobian(const Eigen::VectorXd& x,
                           const Eigen::VectorXd& residuals) const {
    Eigen::MatrixXd jacobian(residuals.size(), x.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const double step = k < 2 ? 1e-3 : 1e-7;
      Eigen::VectorXd beside = x;
      beside[k] += step;
      jacobian.col(k) = (Residuals(beside) - residuals) / step;
    }
    return jacobian;
  }

  const ImageSize size_;
  const std::vector<OcamSample> samples_;
  const FittedModel& initial_model_;
};

}  // namespace

Eigen::Vector3d OcamNumbers::Direction(const Eigen::Vector2d& pixel) const {
  const double x = pixel.y() - row, y = pixel.x() - column;
  const double determinant = c - d * e;
  const double down = (x - d * y) / determinant,
               right = (c * y - e * x) / determinant;
  return {right, down,
          -EvaluatePolynomial(polynomial, std::hypot(down, right))};
}

OcamCamera::OcamCamera(const ImageSize& size, OcamNumbers numbers)
    : CameraModel(size, WholeImage(size)), numbers_(std::move(numbers)) {
  for (const double x : {area().x0, area().x1})
    for (const double y : {area().y0, area().y1})
      max_radius_ =
          std::max(max_radius_, numbers_.Direction({x, y}).head<2>().norm());
}

std::optional<Eigen::Vector3d> OcamCamera::Unproject(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  const Eigen::Vector3d direction = numbers_.Direction(pixel);
  if (!direction.allFinite() || !(direction.norm() > 0)) return std::nullopt;
  return direction.normalized();
}

// Returns the smallest radius whose incidence angle is the given one, by
// Newton's method safeguarded by bisection.
std::optional<double> OcamCamera::Radius(double angle_rad) const {
  constexpr int kSteps = 24, kIterations = 60;
  constexpr double kSearchMargin = 1.25, kTolerance = 1e-13;
  const double sine = std::sin(angle_rad), cosine = std::cos(angle_rad);
  if (sine == 0) return cosine > 0 ? std::optional(0.0) : std::nullopt;
  // Negative while the radius is too small.
  const auto excess = [&](double radius) {
    return radius * cosine +
           EvaluatePolynomial(numbers_.polynomial, radius) * sine;
  };
  const double end = kSearchMargin * max_radius_;
  double low = 0, high = 0;
  for (int k = 1; k <= kSteps && !(excess(high) > 0); ++k) {
    low = high;
    high = end * k / kSteps;
  }
  if (!(excess(high) > 0)) return std::nullopt;
  double radius = (low + high) / 2;
  for (int k = 0; k < kIterations; ++k) {
    const double value = excess(radius);
    (value > 0 ? high : low) = radius;
    double next =
        radius -
        value /
            (cosine + EvaluateDerivative(numbers_.polynomial, radius) * sine);
    if (!(next > low && next < high)) next = (low + high) / 2;
    const double step = std::abs(next - radius);
    radius = next;
    if (step <= kTolerance * end) break;
  }
  return radius;
}

std::optional<Eigen::Vector2d> OcamCamera::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* /*start*/,
    double margin_px) const {
  if (!point.allFinite() || !(point.norm() > 0)) return std::nullopt;
  const double across = point.head<2>().norm();
  const auto radius = Radius(ComputeAngle(point));
  if (!radius) return std::nullopt;
  const Eigen::Vector2d at =
      across > 0 ? Eigen::Vector2d(point.head<2>() * (*radius / across))
                 : Eigen::Vector2d::Zero();
  const Eigen::Vector2d pixel(
      numbers_.e * at.y() + at.x() + numbers_.column,
      numbers_.c * at.y() + numbers_.d * at.x() + numbers_.row);
  return area().Contains(pixel, margin_px) ? std::optional(pixel)
                                           : std::nullopt;
}

Eigen::VectorXd OcamCamera::Parameters() const {
  const auto count = static_cast<Eigen::Index>(numbers_.polynomial.size());
  Eigen::VectorXd parameters(count + 5);
  parameters << numbers_.row, numbers_.column, numbers_.c, numbers_.d,
      numbers_.e,
      Eigen::Map<const Eigen::VectorXd>(numbers_.polynomial.data(), count);
  return parameters;
}

void OcamCamera::SetParameters(const Eigen::VectorXd& parameters) {
  const auto& p = parameters;
  *this = OcamCamera(
      image_size(),
      {{p.data() + 5, p.data() + p.size()}, p[0], p[1], p[2], p[3], p[4]});
}

std::vector<double> InverseOcamPolynomial(const OcamCamera& camera) {
  constexpr int kSamples = 400, kFewest = 5, kMost = 24;
  constexpr double kMaxErrorPx = 0.01;
  std::vector<double> angles, radii;
  for (int k = 0; k <= kSamples; ++k) {
    const double radius = camera.max_radius() * k / kSamples;
    angles.push_back(std::atan2(
        EvaluatePolynomial(camera.numbers().polynomial, radius), radius));
    radii.push_back(radius);
  }
  std::vector<double> best;
  double least_px = INFINITY;
  for (int degree = kFewest; degree <= kMost; ++degree) {
    const std::vector<double> polynomial =
        FitPolynomial(angles, radii, degree, true);
    double worst_px = 0;
    for (size_t k = 0; k < radii.size(); ++k)
      worst_px = std::max(
          worst_px,
          std::abs(EvaluatePolynomial(polynomial, angles[k]) - radii[k]));
    if (worst_px < least_px) {
      least_px = worst_px;
      best = polynomial;
    }
    if (least_px < kMaxErrorPx) break;
  }
  return best;
}

ExternalGrid FitOcamCamera(const CameraModel& camera,
                           const ValidityMask* valid_region) {
  constexpr int kUsualDegree = 4, kMostDegree = 8;
  constexpr double kWorthPart = 0.02, kCloseEnoughPx = 0.002;
  FitOptions options;
  options.valid_region = valid_region;
  options.held = {"p1", "p2", "sx1", "sy1"};
  const FittedModel near = FitNearestModel(models::kThinPrismFisheye, camera,
                                           camera.area(), options);
  const OcamFit fit(camera.image_size(), SampleCamera(camera, valid_region),
                    near);
  OcamFit::FittedPolynomial best = fit.Fit(kUsualDegree);
  for (int degree = kUsualDegree + 1;
       degree <= kMostDegree && best.rms_px > kCloseEnoughPx; ++degree) {
    OcamFit::FittedPolynomial next = fit.Fit(degree);
    if (next.rms_px < (1 - kWorthPart) * best.rms_px) best = std::move(next);
  }
  return {std::make_shared<OcamCamera>(camera.image_size(), best.numbers),
          best.turn};
}

}  // namespace raygrid
