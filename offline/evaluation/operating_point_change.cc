#include "evaluation/operating_point_change.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <optional>
#include <string>

#include "camera/model_fitting.h"

namespace raygrid {
namespace {

// Returns the focal length in pixels per radian at the centre of the area: the
// geometric mean along two axes perpendicular to the line of sight.
double ComputeFocalLengthPx(const CentralGeneric& camera) {
  const Eigen::Vector2d pixel = camera.area().center();
  const auto direction = camera.Unproject(pixel);
  LinearizedProjection projection;
  if (!direction || !camera.Linearize(*direction, &pixel, 1, &projection))
    return NAN;
  const Eigen::Matrix2d square =
      projection.J_point * projection.J_point.transpose();
  return std::pow(square.determinant(), 0.25);
}

Eigen::Vector2d ComputeCenterPx(const CentralGeneric& camera) {
  FitOptions options;
  options.free_rotation = true;
  // These terms, a rotation and a shift of the centre compensate each other.
  options.held = {"p1", "p2", "sx1", "sy1"};
  const auto lens = FitParametricModel(models::kThinPrismFisheye, camera,
                                       camera.area(), options)
                        .model;
  const std::vector<std::string>& names = lens->ParameterNames();
  const Eigen::VectorXd named = lens->Parameters().tail(names.size());
  Eigen::Vector2d center(NAN, NAN);
  for (size_t k = 0; k < names.size(); ++k) {
    if (names[k] == "cx") center.x() = named[static_cast<Eigen::Index>(k)];
    if (names[k] == "cy") center.y() = named[static_cast<Eigen::Index>(k)];
  }
  return center;
}

// Returns the displacements of distant points' projections between two cameras,
// starting from pixels of the first one; NaN where either camera is undefined.
std::vector<Eigen::Vector2d> ComputePixelMotions(
    const CentralGeneric& from, const CentralGeneric& to,
    const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<Eigen::Vector2d> moves;
  for (const Eigen::Vector2d& pixel : pixels) {
    moves.emplace_back(NAN, NAN);
    const auto direction = from.Unproject(pixel);
    if (!direction) continue;
    const auto seen = to.Project(*direction, &pixel, 0.1 * from.area().width());
    if (seen) moves.back() = *seen - pixel;
  }
  return moves;
}

// Removes the scale about a centre and the shift from displacements, and
// returns the scale; nullopt for fewer than three points.
std::optional<double> RemoveScaleAndShift(
    const Eigen::Vector2d& center, const std::vector<Eigen::Vector2d>& pixels,
    std::vector<Eigen::Vector2d>* moves) {
  std::vector<size_t> seen;
  for (size_t k = 0; k < moves->size(); ++k)
    if ((*moves)[k].allFinite()) seen.push_back(k);
  const auto count = static_cast<Eigen::Index>(seen.size());
  if (count < 3) return std::nullopt;
  Eigen::MatrixX3d design(2 * count, 3);
  Eigen::VectorXd observed(2 * count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Vector2d from = pixels[seen[k]] - center;
    design.row(2 * k) << from.x(), 1, 0;
    design.row(2 * k + 1) << from.y(), 0, 1;
    observed.segment<2>(2 * k) = (*moves)[seen[k]];
  }
  const Eigen::Vector3d fitted = design.householderQr().solve(observed);
  const Eigen::VectorXd rest = observed - design * fitted;
  for (Eigen::Index k = 0; k < count; ++k)
    (*moves)[seen[k]] = rest.segment<2>(2 * k);
  return fitted[0];
}

OperatingPointChange ComputeChange(const CentralGeneric& reference,
                                   const CentralGeneric& camera, double value) {
  constexpr int kSteps = 16;
  const Area& area = reference.area();
  std::vector<Eigen::Vector2d> pixels;
  for (int j = 0; j <= kSteps; ++j)
    for (int i = 0; i <= kSteps; ++i)
      pixels.emplace_back(area.x0 + area.width() * i / kSteps,
                          area.y0 + area.height() * j / kSteps);
  std::vector<Eigen::Vector2d> moves =
      ComputePixelMotions(reference, camera, pixels);
  OperatingPointChange change;
  change.value = value;
  change.focal_px = ComputeFocalLengthPx(camera);
  change.center_px = ComputeCenterPx(camera);
  const auto growth = RemoveScaleAndShift(area.center(), pixels, &moves);
  if (!growth) return change;
  change.growth = *growth;
  double sum = 0;
  int count = 0;
  for (const Eigen::Vector2d& move : moves) {
    if (!move.allFinite()) continue;
    sum += move.squaredNorm();
    ++count;
  }
  change.distortion_px = std::sqrt(sum / count);
  return change;
}

}  // namespace

std::vector<OperatingPointChange> MeasureOperatingPointChanges(
    const OperatingPointModel& stack, int num_values) {
  const CentralGeneric reference = stack.At(stack.Center());
  std::vector<OperatingPointChange> changes;
  for (const double value : stack.ranges()[0].SampleValues(num_values))
    changes.push_back(ComputeChange(reference, stack.At({value}), value));
  return changes;
}

std::vector<Eigen::Vector2d> SampleCellCenters(const Area& area, int columns,
                                               int rows) {
  std::vector<Eigen::Vector2d> positions;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      positions.emplace_back(area.x0 + area.width() * (i + 0.5) / columns,
                             area.y0 + area.height() * (j + 0.5) / rows);
  return positions;
}

std::vector<Eigen::Vector2d> MeasureDistortion(
    const CentralGeneric& from, const CentralGeneric& to,
    const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<Eigen::Vector2d> moves = ComputePixelMotions(from, to, pixels);
  RemoveScaleAndShift(from.area().center(), pixels, &moves);
  return moves;
}

}  // namespace raygrid
