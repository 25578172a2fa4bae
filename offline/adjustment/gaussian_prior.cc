#include "adjustment/gaussian_prior.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "camera/noncentral_generic.h"
#include "camera/stereographic.h"

namespace raygrid {
namespace {

// A term of a difference: control point and factor.
struct Term {
  int point;
  double factor;
};

// Those parameters of each control point, out of per_point, that make a field.
struct FieldParameters {
  int per_point, first, count;
};

class DifferenceRows {
 public:
  // pixels_per_unit: of the field at each control point.
  DifferenceRows(const FieldParameters& field,
                 const std::vector<double>& pixels_per_unit)
      : field_(field), scale_(pixels_per_unit) {}

  // One row for each coordinate.
  void Add(const std::vector<Term>& terms, double factor) {
    for (int coordinate = 0; coordinate < field_.count; ++coordinate) {
      for (const Term& term : terms)
        triplets_.emplace_back(
            num_rows_,
            field_.per_point * term.point + field_.first + coordinate,
            factor * term.factor * scale_[term.point]);
      ++num_rows_;
    }
  }

  // D^T D
  Eigen::SparseMatrix<double> Precision() const {
    Eigen::SparseMatrix<double> rows(num_rows_,
                                     field_.per_point * scale_.size());
    rows.setFromTriplets(triplets_.begin(), triplets_.end());
    return rows.transpose() * rows;
  }

 private:
  FieldParameters field_;
  std::vector<double> scale_;
  std::vector<Eigen::Triplet<double>> triplets_;
  int num_rows_ = 0;
};

// A Matern field in the plane (Lindgren, Rue, Lindstrom, "An explicit link
// between Gaussian fields and Gaussian Markov random fields", 2011): precision
// (kappa^2 - Laplacian)^kOrder, smoothness kOrder - 1, and correlation over
// sqrt(8 (kOrder - 1)) / kappa, given as a part of the longer side.
constexpr int kOrder = 3;
constexpr double kRangePart = 0.5;

double Binomial(int n, int k) {
  return k == 0 ? 1 : Binomial(n - 1, k - 1) * n / k;
}

// Differences of an order between neighbours: 1; -1 1; 1 -2 1; ...
double DifferenceFactor(int order, int index) {
  return Binomial(order, index) * ((order - index) % 2 == 0 ? 1 : -1);
}

// The mixed differences of these orders, wherever they fit in the grid.
void AddDerivative(const BSplineSurface& surface, int x_order, int y_order,
                   double factor, DifferenceRows* differences) {
  for (int j = 0; j + y_order < surface.rows(); ++j) {
    for (int i = 0; i + x_order < surface.columns(); ++i) {
      std::vector<Term> terms;
      for (int y = 0; y <= y_order; ++y)
        for (int x = 0; x <= x_order; ++x)
          terms.push_back(
              {(j + y) * surface.columns() + i + x,
               DifferenceFactor(x_order, x) * DifferenceFactor(y_order, y)});
      differences->Add(terms, factor);
    }
  }
}

PriorGroup SmoothField(const BSplineSurface& surface,
                       const FieldParameters& field,
                       const std::vector<double>& pixels_per_unit) {
  DifferenceRows differences(field, pixels_per_unit);
  const double range_px =
      kRangePart * std::max(surface.area().width(), surface.area().height());
  const double cell_px =
      std::sqrt(surface.cell_width() * surface.cell_height());
  const double kappa = std::sqrt(8.0 * (kOrder - 1)) / range_px * cell_px;
  for (int order = 0; order <= kOrder; ++order)
    for (int y_order = 0; y_order <= order; ++y_order)
      AddDerivative(
          surface, order - y_order, y_order,
          std::sqrt(Binomial(kOrder, order) * Binomial(order, y_order)) *
              std::pow(kappa, kOrder - order),
          &differences);
  return {differences.Precision(), field.count * surface.num_points(), 0};
}

// How many pixels a unit of the chart is, around each control point.
std::vector<double> PixelsPerChartUnit(const BSplineSurface& surface) {
  std::vector<double> scales;
  for (int j = 0; j < surface.rows(); ++j) {
    for (int i = 0; i < surface.columns(); ++i) {
      const Area& area = surface.area();
      const Eigen::Vector2d pixel(
          std::clamp(area.x0 + (i - 1) * surface.cell_width(), area.x0,
                     area.x1),
          std::clamp(area.y0 + (j - 1) * surface.cell_height(), area.y0,
                     area.y1));
      Eigen::Matrix2d derivative;
      surface.Evaluate(pixel, &derivative);
      scales.push_back(1 / std::sqrt(std::abs(derivative.determinant())));
    }
  }
  return scales;
}

// Of directions that are the first two of a control point's parameters; without
// the mean.
CameraPrior DirectionsPrior(const BSplineSurface& base, int per_point) {
  const std::vector<double> pixels = PixelsPerChartUnit(base);
  CameraPrior prior;
  prior.groups = {SmoothField(base, {per_point, 0, 2}, pixels)};
  prior.orientation.setZero(per_point * base.num_points(), 3);
  for (int k = 0; k < base.num_points(); ++k)
    prior.orientation.middleRows<2>(per_point * k) =
        ChartRotationDerivative(base.points()[k]);
  prior.orientation /= std::sqrt(base.num_points());
  // As firm as the observations, which have no say in it, are in everything
  // else.
  const double middle = pixels[base.num_points() / 2];
  prior.orientation_weight = middle * middle;
  return prior;
}

}  // namespace

double CameraPrior::Cost(const Eigen::VectorXd& parameters) const {
  const Eigen::VectorXd difference = parameters - mean;
  double cost = 0;
  for (const PriorGroup& group : groups)
    cost += group.weight / 2 * group.SquaredDistance(difference);
  if (orientation.cols() > 0)
    cost += orientation_weight / 2 *
            (orientation.transpose() * difference).squaredNorm();
  return cost;
}

CameraPrior SmoothnessPrior(const CentralGeneric& base) {
  CameraPrior prior = DirectionsPrior(base.surface(), 2);
  prior.mean = base.Parameters();
  return prior;
}

CameraPrior NonCentralPrior(const CentralGeneric& base, double distance_m) {
  constexpr int kPerNode = NonCentralGeneric::kPerNode;
  const BSplineSurface& surface = base.surface();
  CameraPrior prior = DirectionsPrior(surface, kPerNode);
  prior.mean = NonCentralGeneric(base).Parameters();
  const int middle = surface.num_points() / 2;
  const double chart_per_radian =
      (1 + surface.points()[middle].squaredNorm()) / 2;
  const std::vector<double> pixels_per_metre(
      surface.num_points(),
      PixelsPerChartUnit(surface)[middle] * chart_per_radian / distance_m);
  prior.groups.push_back(
      SmoothField(surface, {kPerNode, 2, 3}, pixels_per_metre));
  return prior;
}

CameraPrior DistortionPrior(const OpenCvModel& lens, const Area& area) {
  using Lens = OpenCvModel;
  const Eigen::VectorXd parameters = lens.Parameters();
  const double focal_px = parameters[Lens::kFx];
  const Eigen::Vector2d center(parameters[Lens::kCx], parameters[Lens::kCy]);
  double radius = 0;  // of the farthest corner
  for (const double x : {area.x0, area.x1})
    for (const double y : {area.y0, area.y1})
      radius =
          std::max(radius, (Eigen::Vector2d(x, y) - center).norm() / focal_px);

  std::vector<Eigen::Triplet<double>> diagonal;
  const auto add = [&](int parameter, int order) {
    const double moved_px = focal_px * std::pow(radius, order);
    diagonal.emplace_back(parameter, parameter, moved_px * moved_px);
  };
  for (int k = 0; k < 3; ++k) {
    add(Lens::kK1 + k, 2 * k + 3);
    add(Lens::kK4 + k, 2 * k + 3);
  }
  add(Lens::kP1, 2);
  add(Lens::kP2, 2);

  CameraPrior prior;
  prior.mean = Eigen::VectorXd::Zero(Lens::kCount);
  Eigen::SparseMatrix<double> precision(Lens::kCount, Lens::kCount);
  precision.setFromTriplets(diagonal.begin(), diagonal.end());
  prior.groups = {{precision, static_cast<int>(diagonal.size()), 0}};
  prior.orientation = Eigen::MatrixXd::Zero(Lens::kCount, 0);
  return prior;
}

}  // namespace raygrid
