#include "initialization/radial_initialization.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "initialization/planar_views.h"

namespace raygrid {
namespace {

constexpr size_t kMaxRadialViews = 20;
constexpr int kNumCoefficients = 4;  // coefficients of the polynomial G

double ComputeQuantile(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() +
      static_cast<int>(part * (static_cast<double>(values.size()) - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double ComputeMedian(const std::vector<double>& values) {
  return ComputeQuantile(values, 0.5);
}

// Returns the weights for iteratively reweighted least squares; zero for
// outliers, which are defined by a multiple of the median.
std::vector<double> RobustWeights(const std::vector<double>& errors) {
  std::vector<double> sizes;
  for (const double error : errors) sizes.push_back(std::abs(error));
  const double scale = 3 * ComputeMedian(sizes) + 1e-12;
  std::vector<double> weights;
  for (const double size : sizes) {
    const double part = size / scale;
    weights.push_back(1 / ((1 + part * part) * (1 + part * part)));
  }
  return weights;
}

// ---- Step 1: radial homographies, and the centre ---------------------------

using EquationRows = Eigen::Matrix<double, 2, 3>;  // a, b

// Returns the signed distances of pixels from the radial lines of their points.
std::vector<double> LineErrors(const PlanarView& view,
                               const Eigen::Vector2d& center,
                               const EquationRows& rows) {
  std::vector<double> errors;
  for (size_t i = 0; i < view.points.size(); ++i) {
    const Eigen::Vector2d line = rows * view.points[i].homogeneous();
    const Eigen::Vector2d d = view.pixels[i] - center;
    errors.push_back((d.x() * line.y() - d.y() * line.x()) /
                     (line.norm() + 1e-12));
  }
  return errors;
}

// Estimates a radial homography, with weights that convert algebraic to
// geometric errors and suppress outliers.
EquationRows FitRows(const PlanarView& view, const Eigen::Vector2d& center) {
  constexpr int kRounds = 6;
  std::vector<double> weights(view.points.size(), 1);
  EquationRows rows = EquationRows::Zero();
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    for (size_t i = 0; i < view.points.size(); ++i) {
      const Eigen::RowVector3d q = view.points[i].homogeneous();
      const Eigen::Vector2d d = view.pixels[i] - center;
      Eigen::Matrix<double, 1, 6> row;
      row << -d.y() * q, d.x() * q;
      normal += weights[i] * row.transpose() * row;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(
        normal);
    const Eigen::Matrix<double, 6, 1> solution = eigen.eigenvectors().col(0);
    rows.row(0) = solution.head<3>();
    rows.row(1) = solution.tail<3>();
    weights = RobustWeights(LineErrors(view, center, rows));
    for (size_t i = 0; i < weights.size(); ++i)
      weights[i] /= (rows * view.points[i].homogeneous()).squaredNorm() + 1e-12;
  }
  double side = 0;
  for (size_t i = 0; i < view.points.size(); ++i)
    side +=
        (rows * view.points[i].homogeneous()).dot(view.pixels[i] - center) > 0
            ? 1
            : -1;
  return side < 0 ? EquationRows(-rows) : rows;
}

// Returns the sum of absolute errors, each capped to limit the influence of
// outliers.
double CenterCost(const std::vector<PlanarView>& views,
                  const Eigen::Vector2d& center) {
  constexpr double kErrorLimitPx = 10;
  double cost = 0;
  for (const PlanarView& view : views)
    for (const double error : LineErrors(view, center, FitRows(view, center)))
      cost += std::min(std::abs(error), kErrorLimitPx);
  return cost;
}

// Finds the distortion centre by pattern search around the image centre, within
// a tenth of the image size.
Eigen::Vector2d EstimateCenter(const std::vector<PlanarView>& views,
                               const ImageSize& size) {
  const Eigen::Vector2d image_center((size.width - 1) / 2.0,
                                     (size.height - 1) / 2.0);
  const double limit_px = 0.1 * std::max(size.width, size.height);
  Eigen::Vector2d best = image_center;
  double best_cost = CenterCost(views, best);
  double step_px = limit_px / 2;
  while (step_px > 0.5) {
    const Eigen::Vector2d from = best;
    for (const Eigen::Vector2d& direction :
         {Eigen::Vector2d(1, 0), Eigen::Vector2d(-1, 0), Eigen::Vector2d(0, 1),
          Eigen::Vector2d(0, -1)}) {
      const Eigen::Vector2d tried = from + step_px * direction;
      if ((tried - image_center).cwiseAbs().maxCoeff() > limit_px) continue;
      const double cost = CenterCost(views, tried);
      if (cost >= best_cost) continue;
      best = tried;
      best_cost = cost;
    }
    if (best == from) step_px /= 2;
  }
  return best;
}

// ---- Step 2: poses, except signs and forward translations ------------------

// A view in cylindrical coordinates. Image lengths are in units of half the
// image diagonal.
struct CylindricalView {
  std::vector<double> r;     // radii of pixels
  std::vector<double> rho;   // radii of points
  std::vector<double> tilt;  // r31 X + r32 Y, for s = 1
  double sine = 0;           // sine of the tilt angle
};

CylindricalView ToCylindrical(const PlanarView& view,
                              const Eigen::Vector2d& center, double unit_px) {
  EquationRows rows = FitRows(view, center);
  const Eigen::JacobiSVD<Eigen::Matrix2d> svd(
      rows.leftCols<2>(), Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double larger = svd.singularValues()[0];
  rows /= larger;
  const double cosine = svd.singularValues()[1] / larger;
  CylindricalView result;
  result.sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  for (size_t i = 0; i < view.points.size(); ++i) {
    result.r.push_back((view.pixels[i] - center).norm() / unit_px);
    result.rho.push_back((rows * view.points[i].homogeneous()).norm());
    result.tilt.push_back(result.sine *
                          svd.matrixV().col(1).dot(view.points[i]));
  }
  return result;
}

// ---- Step 3: forward translations and G ------------------------------------

using Coefficients = Eigen::Matrix<double, kNumCoefficients, 1>;

double Polynomial(const Coefficients& g, double r) {
  double value = 0;
  for (int k = kNumCoefficients; k-- > 0;) value = value * r * r + g[k];
  return value;
}

struct RadialSolution {
  Coefficients g = Coefficients::Unit(0);
  std::vector<double> signs, forward;  // s and t3 by view
};

// Returns the difference of the angles of incidence of a point and of its
// pixel.
double ComputeAngleError(const CylindricalView& view, size_t i, double sign,
                         double forward, const Coefficients& g) {
  return std::atan2(view.rho[i], sign * view.tilt[i] + forward) -
         std::atan2(view.r[i], Polynomial(g, view.r[i]));
}

std::vector<double> AzimuthErrors(const CylindricalView& view, double sign,
                                  double forward, const Coefficients& g) {
  std::vector<double> errors;
  for (size_t i = 0; i < view.r.size(); ++i)
    errors.push_back(ComputeAngleError(view, i, sign, forward, g));
  return errors;
}

// Returns the ratio of the algebraic error to the angular error.
double ErrorPerAngle(const CylindricalView& view, size_t i,
                     const Coefficients& g) {
  const double r = view.r[i], along = Polynomial(g, r);
  return view.rho[i] * (r * r + along * along) / std::max(r, 1e-6);
}

// Returns the median over the view's points of t3, for a given sign and G.
double ComputeMedianForward(const CylindricalView& view, double sign,
                            const Coefficients& g) {
  std::vector<double> forward;
  for (size_t i = 0; i < view.r.size(); ++i)
    forward.push_back(view.rho[i] * Polynomial(g, view.r[i]) /
                          std::max(view.r[i], 1e-6) -
                      sign * view.tilt[i]);
  return ComputeMedian(forward);
}

double SumAbsoluteErrors(const std::vector<double>& errors) {
  constexpr double kCap = 0.2;  // radians; limits outliers
  double sum = 0;
  for (const double error : errors) sum += std::min(std::abs(error), kCap);
  return sum;
}

// Solves for all forward translations and for G with the given signs; views
// with sign 0 are ignored. The equations are weighted to minimize angular
// errors, in the first round according to the solution's initial G.
bool SolveForwards(const std::vector<CylindricalView>& views,
                   int num_coefficients, RadialSolution* solution) {
  constexpr int kRounds = 5;
  const int num_views = static_cast<int>(views.size());
  const int size = num_views + num_coefficients;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
    for (int v = 0; v < num_views; ++v) {
      const double sign = solution->signs[v];
      if (sign == 0) {
        normal(v, v) = 1;
        continue;
      }
      std::vector<double> robust(views[v].r.size(), 1);
      if (round > 0)
        robust = RobustWeights(
            AzimuthErrors(views[v], sign, solution->forward[v], solution->g));
      for (size_t i = 0; i < views[v].r.size(); ++i) {
        const double r = views[v].r[i], rho = views[v].rho[i];
        const double per_angle = ErrorPerAngle(views[v], i, solution->g);
        const double weight = robust[i] / (per_angle * per_angle + 1e-12);
        Eigen::VectorXd row(num_coefficients);
        double power = -rho;
        for (int k = 0; k < num_coefficients; ++k, power *= r * r)
          row[k] = power;
        const double target = -sign * views[v].tilt[i] * r;
        normal(v, v) += weight * r * r;
        normal.block(v, num_views, 1, num_coefficients) +=
            weight * r * row.transpose();
        normal.bottomRightCorner(num_coefficients, num_coefficients) +=
            weight * row * row.transpose();
        right[v] += weight * r * target;
        right.tail(num_coefficients) += weight * row * target;
      }
    }
    normal.bottomLeftCorner(num_coefficients, num_views) =
        normal.topRightCorner(num_views, num_coefficients).transpose();
    const Eigen::VectorXd x = normal.ldlt().solve(right);
    if (!x.allFinite()) return false;
    solution->g.setZero();
    solution->g.head(num_coefficients) = x.tail(num_coefficients);
    solution->forward.assign(x.data(), x.data() + num_views);
    if (solution->g[0] < 0) {  // mirrored, an equivalent solution
      solution->g = -solution->g;
      for (int v = 0; v < num_views; ++v) {
        solution->forward[v] *= -1;
        solution->signs[v] *= -1;
      }
    }
  }
  return true;
}

// Selects the sign with the smaller error for each view.
bool ChooseSigns(const std::vector<CylindricalView>& views,
                 RadialSolution* solution) {
  bool changed = false;
  for (size_t v = 0; v < views.size(); ++v) {
    double best = INFINITY, best_sign = 1;
    for (const double sign : {1.0, -1.0}) {
      const double cost = SumAbsoluteErrors(AzimuthErrors(
          views[v], sign, ComputeMedianForward(views[v], sign, solution->g),
          solution->g));
      if (cost >= best) continue;
      best = cost;
      best_sign = sign;
    }
    changed |= solution->signs[v] != best_sign;
    solution->signs[v] = best_sign;
  }
  return changed;
}

// Number of coefficients of G for the first view and for all views. More
// coefficients than the lens requires cause overfitting.
struct Degrees {
  int first, all;
};
constexpr Degrees kDegrees[] = {{1, 1}, {1, 2}, {1, 3}, {2, 3}, {2, 4}};

// Solves for one view first, and then adds the other views.
std::optional<RadialSolution> SolveFromView(
    const std::vector<CylindricalView>& views, size_t first,
    const Degrees& degrees) {
  constexpr int kMaxRounds = 10;
  RadialSolution solution;
  solution.signs.assign(views.size(), 0);
  solution.signs[first] = 1;
  if (!SolveForwards(views, degrees.first, &solution)) return std::nullopt;
  for (int round = 0; round < kMaxRounds; ++round) {
    if (!ChooseSigns(views, &solution) && round > 1) break;
    if (!SolveForwards(views, round == 0 ? degrees.first : degrees.all,
                       &solution))
      return std::nullopt;
  }
  return solution;
}

// Returns the maximum observed radius without outliers.
double ComputeMaxRadius(const std::vector<CylindricalView>& views) {
  std::vector<double> radii;
  for (const CylindricalView& view : views)
    radii.insert(radii.end(), view.r.begin(), view.r.end());
  return ComputeQuantile(radii, 0.98);
}

// Returns d theta / d r of a pixel.
double AnglePerRadius(const Coefficients& g, double r) {
  double slope = 0;  // slope of G divided by r
  for (int k = kNumCoefficients; k-- > 1;) slope = slope * r * r + 2 * k * g[k];
  const double along = Polynomial(g, r);
  return (along - r * r * slope) / (r * r + along * along);
}

// Returns the sum of absolute radial errors, each capped to limit the influence
// of outliers; infinite if the projection folds.
double ComputeCost(const std::vector<CylindricalView>& views, double max_angle,
                   const RadialSolution& solution) {
  constexpr double kCap = 0.05;
  for (double part = 0; part <= 1; part += 0.05)
    if (!(AnglePerRadius(solution.g, part * max_angle) > 0))
      return INFINITY;  // projection folds
  double cost = 0;
  for (size_t v = 0; v < views.size(); ++v) {
    for (size_t i = 0; i < views[v].r.size(); ++i) {
      const double error =
          ComputeAngleError(views[v], i, solution.signs[v], solution.forward[v],
                            solution.g) /
          AnglePerRadius(solution.g, std::min(views[v].r[i], max_angle));
      cost += std::min(std::abs(error), kCap);
    }
  }
  return cost;
}

// ---- Step 4 ----------------------------------------------------------------

// Fits f, f k1 and f k2 by least squares over the observed radii.
std::optional<ThinPrismFisheye> FitThinPrismFisheye(
    const Coefficients& g, double max_angle, double unit_px,
    const Eigen::Vector2d& center, const ImageSize& size) {
  constexpr int kSamples = 50;
  for (int terms = 3; terms >= 1; --terms) {
    Eigen::MatrixXd powers(kSamples, terms);
    Eigen::VectorXd radii(kSamples);
    for (int i = 0; i < kSamples; ++i) {
      const double r = max_angle * (i + 1) / kSamples;
      const double theta = std::atan2(r, Polynomial(g, r));
      radii[i] = r * unit_px;
      for (int k = 0; k < terms; ++k) powers(i, k) = std::pow(theta, 2 * k + 1);
    }
    const Eigen::VectorXd x = powers.colPivHouseholderQr().solve(radii);
    if (!(x[0] > 0) || !x.allFinite()) continue;
    const ThinPrismFisheye lens(
        size, WholeImage(size),
        {x[0], x[0], center.x(), center.y(), terms > 1 ? x[1] / x[0] : 0,
         terms > 2 ? x[2] / x[0] : 0, 0, 0, 0, 0, 0, 0});
    const double needed = powers(kSamples - 1, 0);
    if (lens.max_theta() > std::min(1.02 * needed, 3.0)) return lens;
  }
  return std::nullopt;
}

// Normalizes points by their mean and the maximum norm, for numerical
// conditioning.
void NormalizeViews(std::vector<PlanarView>* views) {
  double largest = 0;
  for (PlanarView& view : *views) {
    Eigen::Vector2d mean(0, 0);
    for (const Eigen::Vector2d& point : view.points) mean += point;
    mean /= static_cast<double>(view.points.size());
    for (Eigen::Vector2d& point : view.points) {
      point -= mean;
      largest = std::max(largest, point.norm());
    }
  }
  for (PlanarView& view : *views)
    for (Eigen::Vector2d& point : view.points) point /= largest;
}

}  // namespace

std::optional<ThinPrismFisheye> InitializeFromRadialLines(
    const Dataset& dataset, const Pattern& pattern) {
  std::vector<PlanarView> planar =
      SamplePlanarViews(dataset, pattern, kMaxRadialViews);
  if (planar.size() < 2) return std::nullopt;
  NormalizeViews(&planar);
  const ImageSize& size = dataset.image_size;
  const double unit_px = std::hypot(size.width, size.height) / 2;
  const Eigen::Vector2d center = EstimateCenter(planar, size);

  std::vector<CylindricalView> views;
  for (const PlanarView& view : planar)
    views.push_back(ToCylindrical(view, center, unit_px));
  const double max_angle = ComputeMaxRadius(views);
  std::optional<RadialSolution> best;
  double best_cost = INFINITY;
  for (size_t first = 0; first < views.size(); ++first) {
    for (const Degrees& degrees : kDegrees) {
      const auto solution = SolveFromView(views, first, degrees);
      if (!solution) continue;
      const double cost = ComputeCost(views, max_angle, *solution);
      if (cost >= best_cost) continue;
      best = solution;
      best_cost = cost;
    }
  }
  if (!best) return std::nullopt;
  return FitThinPrismFisheye(best->g, max_angle, unit_px, center, size);
}

}  // namespace raygrid
