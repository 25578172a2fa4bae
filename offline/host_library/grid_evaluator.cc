#include "host_library/grid_evaluator.h"

#include <algorithm>

#include "camera/noncentral_generic.h"
#include "host_library/batch.h"
#include "host_library/grid_surface.h"
#include "host_library/start_table.h"

namespace raygrid::host {
namespace {

// The area of a grid, in Scalar precision.
template <typename Scalar>
class Bounds {
 public:
  explicit Bounds(const Area& area)
      : x0_(static_cast<Scalar>(area.x0)),
        y0_(static_cast<Scalar>(area.y0)),
        x1_(static_cast<Scalar>(area.x1)),
        y1_(static_cast<Scalar>(area.y1)) {}

  bool Contains(const Vec2<Scalar>& pixel, Scalar margin_px = 0) const {
    return pixel.x() >= x0_ - margin_px && pixel.x() <= x1_ + margin_px &&
           pixel.y() >= y0_ - margin_px && pixel.y() <= y1_ + margin_px;
  }
  Vec2<Scalar> Clamped(const Vec2<Scalar>& pixel) const {
    return {std::clamp(pixel.x(), x0_, x1_), std::clamp(pixel.y(), y0_, y1_)};
  }

 private:
  Scalar x0_, y0_, x1_, y1_;
};

// Limits of the search, for errors of the pixel.
template <typename Scalar>
struct Limits;
template <>
struct Limits<double> {
  static constexpr double kErrorPx = 2e-10, kSmallStepPx = 2e-5, kEdgePx = 1e-6;
};
template <>
struct Limits<float> {
  static constexpr float kErrorPx = 3e-5F, kSmallStepPx = 0.05F,
                         kEdgePx = 2e-4F;
};
constexpr int kMaxSteps = 8;
// Initial values have errors below 1 px, except near folds.
constexpr double kLargeStepPx = 16;

// A line of sight, and its derivatives by the pixel.
template <typename Scalar>
struct LineJet {
  Vec2<Scalar> chart;
  Mat22<Scalar> chart_J;
  Vec3<Scalar> origin;
  Mat32<Scalar> origin_J;
};

template <typename Scalar, bool kIsCentral>
class GridEvaluator final : public Evaluator<Scalar> {
 public:
  GridEvaluator(std::shared_ptr<const CameraModel> model,
                std::shared_ptr<const StartTable> starts)
      : model_(std::move(model)),
        starts_(std::move(starts)),
        bounds_(model_->area()),
        directions_(
            *model_->DirectionGrid(),
            [this](int k) { return model_->DirectionGrid()->points()[k]; }),
        side_(ComputeUnfoldedSide(*model_->DirectionGrid())) {
    if constexpr (!kIsCentral) SetOrigins();
  }

  std::shared_ptr<const Evaluator<Scalar>> WithModel(
      std::shared_ptr<const CameraModel> model) const override {
    auto starts = std::make_shared<const StartTable>(MakeCentral(*model));
    return std::make_shared<GridEvaluator>(std::move(model), std::move(starts));
  }

  bool Unproject(const Vec2<Scalar>& pixel, Vec3<Scalar>* bearing,
                 Mat32<Scalar>* J_pixel) const override {
    if (!bounds_.Contains(pixel)) return false;
    if (J_pixel) {
      const LineJet<Scalar> line = DirectionJet(pixel);
      *bearing = FromChart(line.chart);
      *J_pixel = FromChartJacobian(line.chart) * line.chart_J;
    } else {
      *bearing = FromChart<Scalar>(directions_.Evaluate(pixel));
    }
    return true;
  }

  bool UnprojectLine(const Vec2<Scalar>& pixel, Vec3<Scalar>* origin,
                     Vec3<Scalar>* bearing, Mat32<Scalar>* origin_J,
                     Mat32<Scalar>* bearing_J) const override {
    if (!Unproject(pixel, bearing, bearing_J)) return false;
    if constexpr (kIsCentral) {
      origin->setZero();
      if (origin_J) origin_J->setZero();
    } else if (origin_J) {
      LineJet<Scalar> line;
      AddOrigin(pixel, &line);
      *origin = line.origin;
      *origin_J = line.origin_J;
    } else {
      *origin = origins_.Evaluate(pixel).template head<3>();
    }
    return true;
  }

  bool Project(const Vec3<Scalar>& point, Vec2<Scalar>* pixel,
               Mat23<Scalar>* J_point) const override {
    Vec2<Scalar> found;
    const Result result = FindPixel(point, &found);
    if (result == Result::kUndefined ||
        (result == Result::kUnknown && !SearchPixel(point, &found)))
      return false;
    *pixel = found;
    if (J_point) {
      const LineJet<Scalar> line = Evaluate(found);
      Mat23<Scalar> target_J;
      ToChart<Scalar>(ComputeSightDirection(point, line), &target_J);
      const Mat22<Scalar> J = ErrorJacobian(line, target_J);
      const Scalar determinant = J.determinant();
      for (int k = 0; k < 3; ++k)
        J_point->col(k) = Solve<Scalar>(J, target_J.col(k), determinant);
    }
    return true;
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
  enum class Result { kDefined, kUndefined, kUnknown };

  void SetOrigins() {
    const auto& points =
        static_cast<const NonCentralGeneric&>(*model_).points();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& point : points) sum += point;
    center_ = (sum / static_cast<double>(points.size())).cast<Scalar>();
    origins_ = {*model_->DirectionGrid(), [&](int k) {
                  Eigen::Vector4d padded = Eigen::Vector4d::Zero();
                  padded.head<3>() = points[k];
                  return padded;
                }};
    for (const Eigen::Vector3d& point : points)
      radius_ = std::max(radius_, (point.cast<Scalar>() - center_).norm());
  }

  LineJet<Scalar> DirectionJet(const Vec2<Scalar>& pixel) const {
    const auto at = directions_.EvaluateDerivatives(pixel);
    LineJet<Scalar> line;
    line.chart = at.value;
    line.chart_J.col(0) = at.by_x;
    line.chart_J.col(1) = at.by_y;
    return line;
  }
  void AddOrigin(const Vec2<Scalar>& pixel, LineJet<Scalar>* line) const {
    const auto at = origins_.EvaluateDerivatives(pixel);
    line->origin = at.value.template head<3>();
    line->origin_J.col(0) = at.by_x.template head<3>();
    line->origin_J.col(1) = at.by_y.template head<3>();
  }
  LineJet<Scalar> Evaluate(const Vec2<Scalar>& pixel) const {
    LineJet<Scalar> line = DirectionJet(pixel);
    if constexpr (!kIsCentral) AddOrigin(pixel, &line);
    return line;
  }

  static Vec3<Scalar> ComputeSightDirection(const Vec3<Scalar>& point,
                                            const LineJet<Scalar>& line) {
    if constexpr (kIsCentral)
      return point;
    else
      return point - line.origin;
  }
  // Minus the derivative of (chart of the sight - chart of the line).
  static Mat22<Scalar> ErrorJacobian(const LineJet<Scalar>& line,
                                     const Mat23<Scalar>& target_J) {
    if constexpr (kIsCentral)
      return line.chart_J;
    else
      return line.chart_J + target_J * line.origin_J;
  }

  // Newton's method from the table's initial value, with a Jacobian that is
  // computed again only where the error decreases slowly. A step of length s
  // with a new Jacobian leaves an error of about c s^2, where c < 0.01 / px is
  // the curvature of the mapping. Another one with the same Jacobian multiplies
  // the error by 2 c s, which is twice the ratio of both steps.
  Result FindPixel(const Vec3<Scalar>& point, Vec2<Scalar>* pixel) const {
    constexpr Scalar kSlow2 = Scalar(0.1 * 0.1);
    constexpr Scalar kShort2 =
        Limits<Scalar>::kSmallStepPx * Limits<Scalar>::kSmallStepPx;
    constexpr Scalar kError2 =
        Limits<Scalar>::kErrorPx * Limits<Scalar>::kErrorPx;
    Start start;
    const Result found = FindStart(point, &start);
    if (found != Result::kDefined) return found;
    Vec2<Scalar> at = start.pixel, target = start.target;
    Mat22<Scalar> inverse;
    Scalar previous2 = 0;  // squared length of the last step; 0: new Jacobian
    for (int k = 0; k < kMaxSteps; ++k) {
      if constexpr (!kIsCentral)
        if (k > 0) target = ToChart(ComputeSightFromOrigin(at, point));
      Vec2<Scalar> chart;
      const bool is_new = previous2 == 0;
      if (is_new) {
        const LineJet<Scalar> line = DirectionJet(at);
        if (!InvertUnfolded(line.chart_J + start.parallax, &inverse))
          return Result::kUnknown;
        chart = line.chart;
      } else {
        chart = directions_.Evaluate(at);
      }
      const Vec2<Scalar> step = inverse * (target - chart);
      const Scalar length2 = step.squaredNorm();
      if (!(length2 < Scalar(kLargeStepPx * kLargeStepPx)))
        return Result::kUnknown;
      at += step;
      // The parallax of a non-central camera is an approximation.
      if (is_new ? kIsCentral && length2 < kShort2
                 : 4 * length2 * length2 < kError2 * previous2)
        return AcceptInBounds(at, pixel);
      previous2 = 4 * length2 > kSlow2 * previous2 && !is_new ? 0 : length2;
    }
    return Result::kUnknown;
  }

  // Returns false for the singular Jacobian of a fold, and beyond it.
  bool InvertUnfolded(const Mat22<Scalar>& J, Mat22<Scalar>* inverse) const {
    const Scalar determinant = J.determinant();
    if (side_.folds() ? !(determinant * Scalar(side_.handedness) > 0)
                      : determinant == 0)
      return false;
    *inverse << J(1, 1), -J(0, 1), -J(1, 0), J(0, 0);
    *inverse /= determinant;
    return true;
  }

  Vec3<Scalar> ComputeSightFromOrigin(const Vec2<Scalar>& pixel,
                                      const Vec3<Scalar>& point) const {
    return point - origins_.Evaluate(pixel).template head<3>();
  }

  Result AcceptInBounds(const Vec2<Scalar>& at, Vec2<Scalar>* pixel) const {
    if (!bounds_.Contains(at, Limits<Scalar>::kEdgePx))
      return Result::kUndefined;
    *pixel = bounds_.Clamped(at);
    return Result::kDefined;
  }

  // Initial values of a search.
  struct Start {
    Vec2<Scalar> pixel;
    Vec2<Scalar> target;  ///< chart coordinates of the point, seen from pixel
    /// Minus the derivative of the target by the pixel. It is small and changes
    /// slowly, so that the search takes it as constant.
    Mat22<Scalar> parallax;
  };

  Result FindStart(const Vec3<Scalar>& point, Start* start) const {
    if constexpr (kIsCentral) {
      start->target = ToChart(point);
      start->parallax.setZero();
      return LookUpStart(start->target.template cast<float>(), &start->pixel);
    } else {
      const Vec3<Scalar> sight = point - center_;
      const Result found = LookUpStart(
          ToChart<float>(sight.template cast<float>()), &start->pixel);
      if (found == Result::kDefined) {
        MoveToLine(point, start);
        return found;
      }
      // Seen from other origins, a near point may be in the area: the parallax
      // has to be less than the cell around the table.
      return sight.norm() * Scalar(starts_->CellSize()) > 4 * radius_
                 ? found
                 : Result::kUnknown;
    }
  }

  Result LookUpStart(const Eigen::Vector2f& chart, Vec2<Scalar>* pixel) const {
    Eigen::Vector2f found;
    switch (starts_->Find(chart, &found)) {
      case StartTable::Place::kFound:
        *pixel = found.template cast<Scalar>();
        return Result::kDefined;
      case StartTable::Place::kUnknown:
        return Result::kUnknown;
      case StartTable::Place::kOutside:
        break;
    }
    return Result::kUndefined;
  }

  // Looks the point up again, from the origin of the pixel that it has from the
  // centre of the origins.
  void MoveToLine(const Vec3<Scalar>& point, Start* start) const {
    LineJet<Scalar> line;
    AddOrigin(start->pixel, &line);
    Mat23<Scalar> target_J;
    start->target = ToChart<Scalar>(point - line.origin, &target_J);
    start->parallax = target_J * line.origin_J;
    Vec2<Scalar> moved;
    if (LookUpStart(start->target.template cast<float>(), &moved) !=
        Result::kDefined)
      return;
    start->target -= start->parallax * (moved - start->pixel);
    start->pixel = moved;
  }

  // The model's search from the centre of the area.
  bool SearchPixel(const Vec3<Scalar>& point, Vec2<Scalar>* pixel) const {
    const auto found = model_->CameraModel::Project(
        Eigen::Vector3d(point.template cast<double>()));
    if (found) *pixel = found->template cast<Scalar>();
    return found.has_value();
  }

  std::shared_ptr<const CameraModel> model_;
  std::shared_ptr<const StartTable> starts_;
  Bounds<Scalar> bounds_;
  GridSurface<Scalar, 2> directions_;
  GridSurface<Scalar, 4> origins_;
  Vec3<Scalar> center_ = Vec3<Scalar>::Zero();  // of the origins
  Scalar radius_ = 0;                           // of the origins around it
  UnfoldedSide side_;
};

}  // namespace

template <typename Scalar>
std::shared_ptr<const Evaluator<Scalar>> MakeGridEvaluator(
    std::shared_ptr<const CameraModel> model) {
  auto starts = std::make_shared<const StartTable>(MakeCentral(*model));
  if (model->IsCentral())
    return std::make_shared<GridEvaluator<Scalar, true>>(std::move(model),
                                                         std::move(starts));
  return std::make_shared<GridEvaluator<Scalar, false>>(std::move(model),
                                                        std::move(starts));
}

template std::shared_ptr<const Evaluator<double>> MakeGridEvaluator<double>(
    std::shared_ptr<const CameraModel>);
template std::shared_ptr<const Evaluator<float>> MakeGridEvaluator<float>(
    std::shared_ptr<const CameraModel>);

}  // namespace raygrid::host
