#include "host_library/parametric_evaluator.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "camera/central_generic.h"
#include "camera/pixel_search.h"
#include "camera/stereographic.h"
#include "host_library/batch.h"
#include "host_library/grid_surface.h"

namespace raygrid::host {
namespace {

// Approximate inverse of a formula: a grid fitted to the model's directions,
// and a correction by the grid's own Jacobian, which needs the formula, but not
// its derivatives.
template <typename Scalar>
class ApproximateInverse {
 public:
  explicit ApproximateInverse(const CentralGeneric& grid)
      : surface_(grid.surface(),
                 [&grid](int k) { return grid.surface().points()[k]; }) {}

  // The bearing's chart coordinates, without correction.
  Vec2<Scalar> Evaluate(const Vec2<Scalar>& pixel) const {
    return surface_.Evaluate(pixel);
  }

  // Corrects until the error is below tolerance_px. Each correction multiplies
  // the error by about `contraction`.
  bool Solve(const CameraModel& model, const Vec2<Scalar>& pixel,
             double contraction, double tolerance_px,
             Eigen::Vector2d* chart) const {
    constexpr int kMaxCorrections = 4;
    constexpr double kMarginPx = 2;  // of pixels of uncorrected bearings
    const auto at = surface_.EvaluateDerivatives(pixel);
    const Eigen::Vector2d target = pixel.template cast<double>();
    *chart = at.value.template cast<double>();
    for (int k = 0; k < kMaxCorrections; ++k) {
      const auto found =
          model.Project(raygrid::FromChart(*chart), nullptr, kMarginPx);
      if (!found) return false;
      const Eigen::Vector2d error = target - *found;
      *chart += error.x() * at.by_x.template cast<double>() +
                error.y() * at.by_y.template cast<double>();
      if (contraction * error.norm() < tolerance_px) return true;
    }
    return false;
  }

 private:
  GridSurface<Scalar, 2> surface_;
};

// Errors of an approximate inverse.
struct InverseErrors {
  double uncorrected_px = INFINITY;
  double contraction = 1;  ///< by a correction
};

// Positions, in cells, at which a spline of n cells interpolates: the knots,
// and the centres of the first and last cells.
Eigen::VectorXd InterpolationSites(int num_cells) {
  Eigen::VectorXd sites(num_cells + 3);
  sites << 0, 0.5, Eigen::VectorXd::LinSpaced(num_cells - 1, 1, num_cells - 1),
      num_cells - 0.5, num_cells;
  return sites;
}

// Inverse of the matrix of a spline's weights at its interpolation sites.
Eigen::MatrixXd InterpolationMatrix(int num_cells) {
  const Eigen::VectorXd sites = InterpolationSites(num_cells);
  const int count = num_cells + 3;
  const BSplineSurface line({0, 0, double(num_cells), 1}, count, 4);
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(count, count);
  for (int k = 0; k < count; ++k) {
    const SplineSupport support = line.Support({sites[k], 0});
    for (int n = 0; n < 4; ++n) weights(k, support.column + n) = support.wx[n];
  }
  return weights.inverse();
}

// Interpolates the directions of the area; nullopt if they are not all defined,
// or almost backwards.
std::optional<CentralGeneric> FitInverse(const CameraModel& model) {
  constexpr double kCells = 64,
                   kMaxPlaneRadius = 10;  // 169 degrees off the axis
  const Area& area = model.area();
  const double spacing = std::max(area.width(), area.height()) / kCells;
  const int columns = std::max(NumControlPoints(area.width(), spacing), 5);
  const int rows = std::max(NumControlPoints(area.height(), spacing), 5);
  BSplineSurface surface(area, columns, rows);
  const Eigen::VectorXd x = InterpolationSites(columns - 3);
  const Eigen::VectorXd y = InterpolationSites(rows - 3);
  Eigen::MatrixXd values[2];
  for (Eigen::MatrixXd& value : values) value.resize(rows, columns);
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const auto direction =
          model.Unproject(ClampToArea({area.x0 + x[i] * surface.cell_width(),
                                       area.y0 + y[j] * surface.cell_height()},
                                      area, 0));
      if (!direction) return std::nullopt;
      const Eigen::Vector2d chart = raygrid::ToChart(*direction);
      if (!(chart.norm() < kMaxPlaneRadius)) return std::nullopt;
      for (int k = 0; k < 2; ++k) values[k](j, i) = chart[k];
    }
  }
  const Eigen::MatrixXd by_column =
      InterpolationMatrix(columns - 3).transpose();
  const Eigen::MatrixXd by_row = InterpolationMatrix(rows - 3);
  for (Eigen::MatrixXd& value : values) value = by_row * value * by_column;
  for (int k = 0; k < surface.num_points(); ++k)
    surface.points()[k] << values[0](k / columns, k % columns),
        values[1](k / columns, k % columns);
  return CentralGeneric(model.image_size(), surface);
}

// Measures the inverse at pixels between those of the fit.
InverseErrors MeasureErrors(const CameraModel& model,
                            const CentralGeneric& grid) {
  InverseErrors errors = {0, 0};
  const Area& area = model.area();
  constexpr int kAlong = 24;
  int num_defined = 0;
  for (int j = 0; j < kAlong; ++j) {
    for (int i = 0; i < kAlong; ++i) {
      const Eigen::Vector2d pixel(area.x0 + area.width() * (i + 0.4) / kAlong,
                                  area.y0 + area.height() * (j + 0.6) / kAlong);
      if (!model.Unproject(pixel)) continue;
      Eigen::Matrix2d by_pixel;
      const Eigen::Vector2d chart = grid.surface().Evaluate(pixel, &by_pixel);
      const auto first = model.Project(raygrid::FromChart(chart), nullptr, 2);
      if (!first) return {};
      const Eigen::Vector2d error = pixel - *first;
      const auto second = model.Project(
          raygrid::FromChart(chart + by_pixel * error), nullptr, 2);
      if (!second) return {};
      errors.uncorrected_px = std::max(errors.uncorrected_px, error.norm());
      if (error.norm() > 1e-9)  // below, rounding dominates
        errors.contraction = std::max(errors.contraction,
                                      (pixel - *second).norm() / error.norm());
      ++num_defined;
    }
  }
  return num_defined > 0 ? errors : InverseErrors();
}

template <typename Scalar>
struct Tolerance;
template <>
struct Tolerance<double> {
  static constexpr double kPx = 2e-10, kUncorrectedPx = 1e-11;
};
template <>
struct Tolerance<float> {
  static constexpr double kPx = 1e-4, kUncorrectedPx = 3e-4;
};

template <typename Scalar>
class ParametricEvaluator final : public Evaluator<Scalar> {
 public:
  ParametricEvaluator(std::shared_ptr<const CameraModel> model,
                      std::shared_ptr<const ApproximateInverse<Scalar>> inverse,
                      const InverseErrors& errors)
      : model_(std::move(model)),
        inverse_(std::move(inverse)),
        errors_(errors) {}

  std::shared_ptr<const Evaluator<Scalar>> WithModel(
      std::shared_ptr<const CameraModel> model) const override {
    return std::make_shared<ParametricEvaluator>(std::move(model), inverse_,
                                                 InverseErrors());
  }

  bool Unproject(const Vec2<Scalar>& pixel, Vec3<Scalar>* bearing,
                 Mat32<Scalar>* J_pixel) const override {
    if (!J_pixel) return FindBearing(pixel, bearing);
    Vec3<Scalar> found;
    if (!FindBearing(pixel, &found) || !ComputeJacobian(found, J_pixel))
      return false;
    *bearing = found;
    return true;
  }

  bool UnprojectLine(const Vec2<Scalar>& pixel, Vec3<Scalar>* origin,
                     Vec3<Scalar>* bearing, Mat32<Scalar>* origin_J,
                     Mat32<Scalar>* bearing_J) const override {
    if (!Unproject(pixel, bearing, bearing_J)) return false;
    origin->setZero();
    if (origin_J) origin_J->setZero();
    return true;
  }

  bool Project(const Vec3<Scalar>& point, Vec2<Scalar>* pixel,
               Mat23<Scalar>* J_point) const override {
    const Eigen::Vector3d at = point.template cast<double>();
    if (J_point) {
      LinearizedProjection projection;
      if (!model_->Linearize(at, nullptr, 0, &projection)) return false;
      *pixel = projection.pixel.cast<Scalar>();
      *J_point = projection.J_point.cast<Scalar>();
      return true;
    }
    const auto found = model_->Project(at, nullptr, 0);
    if (found) *pixel = found->template cast<Scalar>();
    return found.has_value();
  }

  int UnprojectAll(Columns<const Scalar> pixels, int count,
                   Columns<Scalar> origins,
                   Columns<Scalar> bearings) const override {
    return UnprojectArray<Scalar>(*this, pixels, count, origins, bearings);
  }
  int ProjectAll(Columns<const Scalar> points, int count,
                 Columns<Scalar> pixels) const override {
    return ProjectArray<Scalar>(*this, points, count, pixels);
  }

 private:
  bool FindBearing(const Vec2<Scalar>& pixel, Vec3<Scalar>* bearing) const {
    const Eigen::Vector2d at = pixel.template cast<double>();
    if (!model_->area().Contains(at)) return false;
    if (inverse_ &&
        errors_.uncorrected_px < Tolerance<Scalar>::kUncorrectedPx) {
      *bearing = FromChart<Scalar>(inverse_->Evaluate(pixel));
      return true;
    }
    Eigen::Vector2d chart;
    if (inverse_ && inverse_->Solve(*model_, pixel, errors_.contraction,
                                    Tolerance<Scalar>::kPx, &chart)) {
      *bearing = raygrid::FromChart(chart).template cast<Scalar>();
      return true;
    }
    const auto found = model_->Unproject(at);
    if (found) *bearing = found->template cast<Scalar>();
    return found.has_value();
  }

  // d bearing / d pixel, the inverse of J_point in the plane orthogonal to the
  // bearing.
  bool ComputeJacobian(const Vec3<Scalar>& bearing,
                       Mat32<Scalar>* J_pixel) const {
    constexpr double kMarginPx = 1e-3;
    const Eigen::Vector3d direction =
        bearing.template cast<double>().normalized();
    LinearizedProjection projection;
    if (!model_->Linearize(direction, nullptr, kMarginPx, &projection))
      return false;
    Eigen::Matrix<double, 3, 2> tangent;
    tangent.col(0) = direction.unitOrthogonal();
    tangent.col(1) = direction.cross(tangent.col(0));
    const Eigen::Matrix2d J = projection.J_point * tangent;
    const double determinant = J.determinant();
    if (!(std::abs(determinant) > 0)) return false;
    Eigen::Matrix2d inverse;
    inverse << J(1, 1), -J(0, 1), -J(1, 0), J(0, 0);
    *J_pixel = (tangent * inverse / determinant).template cast<Scalar>();
    return true;
  }

  std::shared_ptr<const CameraModel> model_;
  std::shared_ptr<const ApproximateInverse<Scalar>> inverse_;
  InverseErrors errors_;
};

}  // namespace

template <typename Scalar>
std::shared_ptr<const Evaluator<Scalar>> MakeParametricEvaluator(
    std::shared_ptr<const CameraModel> model) {
  InverseErrors errors;
  std::shared_ptr<const ApproximateInverse<Scalar>> inverse;
  if (const auto grid = FitInverse(*model)) {
    errors = MeasureErrors(*model, *grid);
    if (errors.uncorrected_px < 1 && errors.contraction < 0.5)
      inverse = std::make_shared<const ApproximateInverse<Scalar>>(*grid);
  }
  return std::make_shared<ParametricEvaluator<Scalar>>(
      std::move(model), std::move(inverse), errors);
}

template std::shared_ptr<const Evaluator<double>>
    MakeParametricEvaluator<double>(std::shared_ptr<const CameraModel>);
template std::shared_ptr<const Evaluator<float>> MakeParametricEvaluator<float>(
    std::shared_ptr<const CameraModel>);

}  // namespace raygrid::host
