#include "adjustment/smoothness_prior.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>

#include "adjustment/matern_field.h"
#include "camera/lattice_fit.h"
#include "camera/noncentral_generic.h"
#include "camera/stereographic.h"

namespace raygrid {
namespace {

// Term of a finite difference: a control point and its coefficient.
struct Term {
  int point;
  double coefficient;
};

// Parameters of a field: `count` of the `per_point` parameters of each control
// point, from index `first`.
struct FieldParameters {
  int per_point, first, count;

  int GetParameterIndex(int point) const { return per_point * point + first; }
};

class DifferenceRows {
 public:
  // pixels_per_unit: scale of the field at each control point.
  DifferenceRows(const FieldParameters& field,
                 const std::vector<double>& pixels_per_unit)
      : field_(field), scale_(pixels_per_unit) {}

  // Adds one row for each coordinate.
  void Add(const std::vector<Term>& terms, double weight) {
    for (int coordinate = 0; coordinate < field_.count; ++coordinate) {
      for (const Term& term : terms)
        triplets_.emplace_back(
            num_rows_,
            field_.per_point * term.point + field_.first + coordinate,
            weight * term.coefficient * scale_[term.point]);
      ++num_rows_;
    }
  }

  // Returns the precision matrix D^T D.
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

// Adds the mixed differences of the given orders at all positions in the grid.
void AddDerivative(const BSplineSurface& surface, int x_order, int y_order,
                   double weight, DifferenceRows* differences) {
  for (int j = 0; j + y_order < surface.rows(); ++j) {
    for (int i = 0; i + x_order < surface.columns(); ++i) {
      std::vector<Term> terms;
      for (int y = 0; y <= y_order; ++y)
        for (int x = 0; x <= x_order; ++x)
          terms.push_back(
              {(j + y) * surface.columns() + i + x,
               DifferenceFactor(x_order, x) * DifferenceFactor(y_order, y)});
      differences->Add(terms, weight);
    }
  }
}

PriorGroup SmoothGroup(const BSplineSurface& surface,
                       const FieldParameters& field,
                       const std::vector<double>& pixels_per_unit) {
  DifferenceRows differences(field, pixels_per_unit);
  const double kappa =
      MaternKappa(std::max(surface.area().width(), surface.area().height()),
                  std::sqrt(surface.cell_width() * surface.cell_height()));
  for (int order = 0; order <= kMaternOrder; ++order)
    for (int y_order = 0; y_order <= order; ++y_order)
      AddDerivative(
          surface, order - y_order, y_order,
          std::sqrt(Binomial(kMaternOrder, order) * Binomial(order, y_order)) *
              std::pow(kappa, kMaternOrder - order),
          &differences);
  PriorGroup group;
  group.precision = differences.Precision();
  group.rank = field.count * surface.num_points();
  return group;
}

// Returns the Jacobian of the surface at a control point, clamped to the
// calibrated area.
Eigen::Matrix2d ChartDerivative(const BSplineSurface& surface,
                                const Eigen::Vector2d& pixel) {
  const Area& area = surface.area();
  Eigen::Matrix2d derivative;
  surface.Evaluate({std::clamp(pixel.x(), area.x0, area.x1),
                    std::clamp(pixel.y(), area.y0, area.y1)},
                   &derivative);
  return derivative;
}

// Returns the scale of the chart at a pixel, in pixels per chart unit.
double PixelsPerChartUnitAt(const BSplineSurface& surface,
                            const Eigen::Vector2d& pixel) {
  return 1 / std::sqrt(std::abs(ChartDerivative(surface, pixel).determinant()));
}

// Returns the scale of the chart at each control point, in pixels per chart
// unit.
std::vector<double> PixelsPerChartUnit(const BSplineSurface& surface) {
  std::vector<double> scales;
  for (int i = 0; i < surface.num_points(); ++i)
    scales.push_back(PixelsPerChartUnitAt(surface, surface.GetPixel(i)));
  return scales;
}

// Returns the unpenalized displacements (px) of a camera without a parametric
// model: scale in x and y, shifts in both directions, then radial terms of
// third, fifth and seventh order, normalized to one pixel in the corners of the
// area.
Eigen::Matrix2Xd PolynomialDisplacements(const Area& area,
                                         const Eigen::Vector2d& pixel) {
  constexpr int kNumRadial = 3;
  const Eigen::Vector2d offset = (pixel - area.center()) / area.width();
  const Eigen::Vector2d to_corner =
      (pixel - area.center()) * 2 / std::hypot(area.width(), area.height());
  Eigen::Matrix2Xd displacements(2, 4 + kNumRadial);
  displacements.leftCols<4>() << offset.x(), 0, 1, 0,  //
      0, offset.y(), 0, 1;
  for (int k = 0; k < kNumRadial; ++k)
    displacements.col(4 + k) =
        to_corner * std::pow(to_corner.squaredNorm(), k + 1);
  return displacements;
}

// Returns the prior precision of the radial terms, which are penalized a
// hundredth as much as a pixel of the field. This does not affect observable
// directions; but if the features cover a small part of the image, high orders
// would otherwise displace the remainder by arbitrary amounts.
Eigen::VectorXd PolynomialPrecisions() {
  constexpr double kRadialPrecision = 1e-4;
  Eigen::VectorXd relative_precisions = Eigen::VectorXd::Zero(7);
  relative_precisions.tail<3>().setConstant(kRadialPrecision);
  return relative_precisions;
}

// Displacement of a pixel per unit of each model parameter. Outside the image
// circle, the displacement at the last pixel inside is used.
class ParameterDisplacements {
 public:
  ParameterDisplacements(const ParametricModel& lens, const Area& area)
      : lens_(lens.CloneWithArea(area)), center_(area.center()) {}

  Eigen::Matrix2Xd At(const Eigen::Vector2d& pixel) const {
    constexpr int kSteps = 64;
    for (int step = kSteps; step > 0; --step) {
      const Eigen::Vector2d nearer =
          center_ + (pixel - center_) * step / static_cast<double>(kSteps);
      const auto ray = lens_->Unproject(nearer);
      LinearizedProjection projection;
      if (ray && lens_->Linearize(*ray, &nearer, 1, &projection))
        return projection.J_global.leftCols(projection.num_global);
    }
    return Eigen::Matrix2Xd::Zero(2, lens_->NumParameters());
  }

 private:
  std::unique_ptr<ParametricModel> lens_;
  Eigen::Vector2d center_;
};

// Fits control points, one column each, to values at pixels. Beyond the area,
// the values are extrapolated smoothly, since the smoothness prior would
// penalize a kink.
Eigen::MatrixXd ControlValues(
    const BSplineSurface& surface, const FieldParameters& field,
    const std::function<Eigen::MatrixXd(const Eigen::Vector2d&)>& at) {
  const LatticeFit fit(surface);
  const Eigen::Index count = at(fit.pixels()[0]).cols();
  Eigen::MatrixXd values(fit.pixels().size(), 2 * count);
  for (size_t i = 0; i < fit.pixels().size(); ++i)
    values.row(i) = at(fit.pixels()[i]).reshaped().transpose();
  Eigen::MatrixXd result =
      Eigen::MatrixXd::Zero(field.per_point * surface.num_points(), count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::VectorXd x = fit.Of(values.col(2 * k)),
                          y = fit.Of(values.col(2 * k + 1));
    for (int i = 0; i < surface.num_points(); ++i)
      result.col(k).segment<2>(field.GetParameterIndex(i)) << x[i], y[i];
  }
  return result;
}

// Returns the Jacobian of the control points with respect to the model's
// parameters.
UnpenalizedDirections FreeParameters(const BSplineSurface& surface,
                                     const FieldParameters& field,
                                     const BaseModel& lens) {
  const ParameterDisplacements displacements(*lens.model, surface.area());
  UnpenalizedDirections unpenalized;
  unpenalized.directions =
      ControlValues(surface, field, [&](const Eigen::Vector2d& pixel) {
        return Eigen::MatrixXd(ChartDerivative(surface, pixel) *
                               displacements.At(pixel));
      });
  unpenalized.relative_precisions =
      Eigen::VectorXd::Zero(lens.precision.size());
  unpenalized.precision_floor = lens.precision;
  return unpenalized;
}

// Returns the Jacobian of the control points with respect to the unpenalized
// polynomials, for cameras without a parametric model.
UnpenalizedDirections FreePolynomials(const BSplineSurface& surface,
                                      const FieldParameters& field) {
  UnpenalizedDirections unpenalized;
  unpenalized.relative_precisions = PolynomialPrecisions();
  unpenalized.precision_floor =
      Eigen::VectorXd::Zero(unpenalized.relative_precisions.size());
  unpenalized.directions =
      Eigen::MatrixXd::Zero(field.per_point * surface.num_points(),
                            unpenalized.relative_precisions.size());
  for (int i = 0; i < surface.num_points(); ++i) {
    const Eigen::Vector2d pixel = surface.GetPixel(i);
    unpenalized.directions.middleRows<2>(field.GetParameterIndex(i)) =
        ChartDerivative(surface, pixel) *
        PolynomialDisplacements(surface.area(), pixel);
  }
  return unpenalized;
}

// Returns the mean rotation of the directions of pixels, in pixels, as a linear
// function of the control points.
Eigen::MatrixXd MeanRotation(const BSplineSurface& surface,
                             const FieldParameters& field,
                             const std::vector<Eigen::Vector2d>& pixels,
                             double center_px_per_unit) {
  Eigen::MatrixXd rotation =
      Eigen::MatrixXd::Zero(field.per_point * surface.num_points(), 3);
  for (const Eigen::Vector2d& pixel : pixels) {
    // Reduces the weight of pixels where the model folds or is extrapolated: a
    // chart unit may correspond to arbitrarily many pixels there.
    const double scale =
        PixelsPerChartUnitAt(surface, pixel) / center_px_per_unit;
    const Eigen::Matrix<double, 2, 3> J_rotation =
        std::pow(std::min(scale, 1 / scale), 2) *
        ChartRotationDerivative(surface.Evaluate(pixel));
    const SplineSupport support = surface.Support(pixel);
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i)
        rotation.middleRows<2>(field.GetParameterIndex(
            (support.row + j) * surface.columns() + support.column + i)) +=
            support.wx[i] * support.wy[j] * J_rotation;
  }
  return rotation / static_cast<double>(pixels.size());
}

// Adds the principal directions of a camera population to those of the model.
// Their coefficients are standard normal, so their precision is 1.
UnpenalizedDirections AddPopulationDirections(
    const UnpenalizedDirections& lens, const BSplineSurface& surface,
    const FieldParameters& field, const std::vector<BSplineSurface>& spread) {
  const Eigen::MatrixXd moved =
      ControlValues(surface, field, [&](const Eigen::Vector2d& pixel) {
        Eigen::MatrixXd displacements(2, spread.size());
        for (size_t k = 0; k < spread.size(); ++k) {
          const Area& area = spread[k].area();
          displacements.col(k) =
              spread[k].Evaluate({std::clamp(pixel.x(), area.x0, area.x1),
                                  std::clamp(pixel.y(), area.y0, area.y1)});
        }
        return Eigen::MatrixXd(ChartDerivative(surface, pixel) * displacements);
      });
  UnpenalizedDirections all;
  all.directions.resize(moved.rows(), lens.directions.cols() + moved.cols());
  all.directions << lens.directions, moved;
  all.relative_precisions.resize(all.directions.cols());
  all.relative_precisions << lens.relative_precisions,
      Eigen::VectorXd::Zero(moved.cols());
  all.precision_floor.resize(all.directions.cols());
  all.precision_floor << lens.precision_floor,
      Eigen::VectorXd::Ones(moved.cols());
  return all;
}

// Removes the rotation about the pixels of the orientation term from
// directions. Otherwise, a shift of the principal point would include a
// rotation, which smooth deformations would have to compensate.
Eigen::MatrixXd RemoveRotations(const Eigen::MatrixXd& directions,
                                const Eigen::MatrixXd& orientation,
                                const BSplineSurface& surface,
                                const FieldParameters& field) {
  const Eigen::MatrixXd rotation_columns =
      ControlValues(surface, field, [&](const Eigen::Vector2d& pixel) {
        return Eigen::MatrixXd(
            ChartRotationDerivative(surface.Evaluate(pixel)));
      });
  const Eigen::Matrix3d by_turn = orientation.transpose() * rotation_columns;
  return directions - rotation_columns * by_turn.inverse() *
                          (orientation.transpose() * directions);
}

// Returns the prior of the directions, or of their change with an operating
// point, without a mean: for two parameters of each control point.
CameraPrior MakeDirectionsPrior(
    const BSplineSurface& base, const FieldParameters& field,
    const std::vector<Eigen::Vector2d>& observed_px, const BaseModel& lens = {},
    const std::vector<BSplineSurface>& spread = {}) {
  constexpr int kPerCell = 4;
  CameraPrior prior;
  prior.base_lens = lens;
  prior.spread = spread;
  prior.groups = {SmoothGroup(base, field, PixelsPerChartUnit(base))};
  // The orientation is defined by displacements in pixels, since in chart
  // units, unobserved directions behind the camera would dominate. The
  // precision of this term is similar to that of the other parameters given the
  // observations, which do not depend on it.
  const double center_px_per_unit =
      PixelsPerChartUnitAt(base, base.area().center());
  prior.orientation =
      std::sqrt(base.num_points()) *
      MeanRotation(
          base, field,
          observed_px.empty() ? base.SamplePixels(kPerCell) : observed_px,
          center_px_per_unit);
  prior.orientation_precision = center_px_per_unit * center_px_per_unit;
  UnpenalizedDirections unpenalized = lens.model
                                          ? FreeParameters(base, field, lens)
                                          : FreePolynomials(base, field);
  if (!spread.empty()) {
    unpenalized = AddPopulationDirections(unpenalized, base, field, spread);
    unpenalized.directions =
        RemoveRotations(unpenalized.directions, prior.orientation, base, field);
  }
  prior.groups[0].Unpenalize(unpenalized);
  return prior;
}

// Precision of a point's position along its observation line, relative to that
// of differences between neighbours. The position is not observable and should
// not affect the result.
constexpr double kPrecision = 1e4;

Eigen::SparseMatrix<double> MakeLinePositionRows(
    const BSplineSurface& directions, double pixels_per_metre) {
  std::vector<Eigen::Triplet<double>> triplets;
  int first = NonCentralGeneric::kFirstOfPoint;
  for (const Eigen::Vector2d& chart : directions.points()) {
    const Eigen::Vector3d along = pixels_per_metre * FromChart(chart);
    for (int k = 0; k < 9; ++k)
      triplets.emplace_back(first + k % 3, first + k / 3,
                            kPrecision * along[k % 3] * along[k / 3]);
    first += NonCentralGeneric::kPerNode;
  }
  const int size = NonCentralGeneric::kPerNode * directions.num_points();
  Eigen::SparseMatrix<double> precision(size, size);
  precision.setFromTriplets(triplets.begin(), triplets.end());
  return precision;
}

}  // namespace

CameraPrior MakeSmoothnessPrior(const CentralGeneric& base,
                                const std::vector<Eigen::Vector2d>& observed_px,
                                const BaseModel& lens,
                                const std::vector<BSplineSurface>& spread) {
  CameraPrior prior =
      MakeDirectionsPrior(base.surface(), {2, 0, 2}, observed_px, lens, spread);
  prior.mean = base.Parameters();
  return prior;
}

CameraPrior MakeOperatingPointPrior(const CentralGeneric& base, int num_terms) {
  const BSplineSurface& surface = base.surface();
  CameraPrior prior;
  prior.mean = Eigen::VectorXd::Zero(2 * num_terms * surface.num_points());
  for (int k = 0; k < surface.num_points(); ++k)
    prior.mean.segment<2>(2 * num_terms * k) = surface.points()[k];
  prior.orientation.resize(prior.mean.size(), 3 * num_terms);
  for (int term = 0; term < num_terms; ++term) {
    CameraPrior term_prior =
        MakeDirectionsPrior(surface, {2 * num_terms, 2 * term, 2}, {});
    prior.groups.push_back(std::move(term_prior.groups[0]));
    prior.orientation.middleCols<3>(3 * term) = term_prior.orientation;
    prior.orientation_precision = term_prior.orientation_precision;
  }
  return prior;
}

CameraPrior MakeNonCentralPrior(const CentralGeneric& base,
                                const std::vector<Eigen::Vector2d>& observed_px,
                                double distance_m, const BaseModel& lens) {
  constexpr int kPerNode = NonCentralGeneric::kPerNode;
  const BSplineSurface& surface = base.surface();
  CameraPrior prior =
      MakeDirectionsPrior(surface, {kPerNode, 0, 2}, observed_px, lens);
  prior.mean = NonCentralGeneric(base).Parameters();
  const int center = surface.num_points() / 2;
  const double chart_per_radian =
      (1 + surface.points()[center].squaredNorm()) / 2;
  const std::vector<double> pixels_per_metre(
      surface.num_points(),
      PixelsPerChartUnit(surface)[center] * chart_per_radian / distance_m);
  PriorGroup points =
      SmoothGroup(surface, {kPerNode, NonCentralGeneric::kFirstOfPoint, 3},
                  pixels_per_metre);
  points.precision += MakeLinePositionRows(surface, pixels_per_metre[center]);
  prior.groups.push_back(std::move(points));
  return prior;
}

}  // namespace raygrid
