#include "adjustment/gaussian_prior.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "camera/stereographic.h"

namespace raygrid {
namespace {

// A term of a difference: control point and factor.
struct Term {
  int point;
  double factor;
};

class DifferenceRows {
 public:
  explicit DifferenceRows(const std::vector<double>& pixels_per_chart_unit)
      : scale_(pixels_per_chart_unit) {}

  // One row for each coordinate.
  void Add(const std::vector<Term>& terms, double factor) {
    for (int coordinate = 0; coordinate < 2; ++coordinate) {
      for (const Term& term : terms)
        triplets_.emplace_back(num_rows_, 2 * term.point + coordinate,
                               factor * term.factor * scale_[term.point]);
      ++num_rows_;
    }
  }

  // D^T D
  Eigen::SparseMatrix<double> Precision() const {
    Eigen::SparseMatrix<double> rows(num_rows_, 2 * scale_.size());
    rows.setFromTriplets(triplets_.begin(), triplets_.end());
    return rows.transpose() * rows;
  }

 private:
  std::vector<double> scale_;
  std::vector<Eigen::Triplet<double>> triplets_;
  int num_rows_ = 0;
};

// The distance over which departures from the parametric lens are correlated,
// as a part of the longer side.
constexpr double kRangePart = 0.5;

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

}  // namespace

GaussianPrior SmoothnessPrior(const CentralGeneric& base) {
  const BSplineSurface& surface = base.surface();
  const int columns = surface.columns(), rows = surface.rows();
  DifferenceRows differences(PixelsPerChartUnit(surface));
  // In cells; (cell kappa)^2 and its square weigh slopes and values.
  const double kappa =
      std::sqrt(8.0) /
      (kRangePart * std::max(surface.area().width(), surface.area().height())) *
      std::sqrt(surface.cell_width() * surface.cell_height());
  const double slope_factor = std::sqrt(2.0) * kappa;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int k = j * columns + i;
      const bool right = i + 1 < columns, below = j + 1 < rows;
      if (i > 0 && right) differences.Add({{k - 1, 1}, {k, -2}, {k + 1, 1}}, 1);
      if (j > 0 && below)
        differences.Add({{k - columns, 1}, {k, -2}, {k + columns, 1}}, 1);
      if (right && below)
        differences.Add(
            {{k, 1}, {k + 1, -1}, {k + columns, -1}, {k + columns + 1, 1}},
            std::sqrt(2));
      if (right) differences.Add({{k, -1}, {k + 1, 1}}, slope_factor);
      if (below) differences.Add({{k, -1}, {k + columns, 1}}, slope_factor);
      differences.Add({{k, 1}}, kappa * kappa);
    }
  }

  GaussianPrior prior;
  prior.camera_mean = base.Parameters();
  prior.camera_precision = differences.Precision();
  prior.camera_rank = 2 * surface.num_points();
  prior.orientation.resize(2 * surface.num_points(), 3);
  for (int k = 0; k < surface.num_points(); ++k)
    prior.orientation.middleRows<2>(2 * k) =
        ChartRotationDerivative(surface.points()[k]);
  prior.orientation /= std::sqrt(surface.num_points());
  // As firm as the observations, which have no say in it, are in everything
  // else.
  const double pixels = PixelsPerChartUnit(surface)[surface.num_points() / 2];
  prior.orientation_weight = pixels * pixels;
  return prior;
}

GaussianPrior DistortionPrior(const OpenCvModel& lens, const Area& area) {
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

  GaussianPrior prior;
  prior.camera_mean = Eigen::VectorXd::Zero(Lens::kCount);
  prior.camera_precision.resize(Lens::kCount, Lens::kCount);
  prior.camera_precision.setFromTriplets(diagonal.begin(), diagonal.end());
  prior.camera_rank = static_cast<int>(diagonal.size());
  prior.orientation = Eigen::MatrixXd::Zero(Lens::kCount, 0);
  return prior;
}

}  // namespace raygrid
