#include "python/camera_points.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "camera/camera_frame.h"
#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

// The number of points per task; smaller tasks do not justify a thread.
constexpr size_t kPointsPerChunk = 4096;

// Calls body(first, end) for subranges of [0, count) in parallel, without the
// GIL.
template <typename Body>
void ParallelForRanges(size_t count, int num_threads, const Body& body) {
  const py::gil_scoped_release released;
  const int parts =
      static_cast<int>((count + kPointsPerChunk - 1) / kPointsPerChunk);
  ParallelFor(parts, NumThreads(num_threads), [&](int part) {
    const size_t first = part * kPointsPerChunk;
    body(first, std::min(count, first + kPointsPerChunk));
  });
}

template <int n>
void CopyVector(const Eigen::Matrix<double, n, 1>& vector, double* place) {
  Eigen::Map<Eigen::Matrix<double, n, 1>>{place} = vector;
}

// ---- Points ----------------------------------------------------------------

// Scales a point, without changing its image, such that its squared norm
// neither overflows nor underflows. For a central camera, the distance is
// irrelevant; for others, a point is scaled only at distances above 2^100 m.
Eigen::Vector3d ScaleToAvoidOverflow(const Eigen::Vector3d& point,
                                     bool is_central, int* shift) {
  constexpr int kFarAway = 100, kMaxExponent = 300;
  const double largest = point.cwiseAbs().maxCoeff();
  *shift = 0;
  if (largest < std::ldexp(1, kFarAway) &&
      !(is_central && largest < std::ldexp(1, -kMaxExponent)))
    return point;
  int exponent = 0;
  std::frexp(largest, &exponent);
  *shift = is_central ? -exponent : kFarAway - exponent;
  return point.unaryExpr([shift](double x) { return std::ldexp(x, *shift); });
}

// Computes the pixel of a point, and the Jacobian unless by_point is null; NaN
// if the point does not project.
void ProjectPoint(const CameraModel& camera, bool is_central,
                  const double* given, double* pixel, double* by_point) {
  int shift = 0;
  const Eigen::Vector3d point = ScaleToAvoidOverflow(
      Eigen::Map<const Eigen::Vector3d>(given), is_central, &shift);
  if (!by_point) {
    const auto found = camera.Project(point);
    CopyVector<2>(found && camera.IsInImageCircle(*found)
                      ? *found
                      : Eigen::Vector2d(NAN, NAN),
                  pixel);
    return;
  }
  Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> derivative(by_point);
  LinearizedProjection found;
  if (camera.Linearize(point, nullptr, 0, &found) &&
      camera.IsInImageCircle(found.pixel)) {
    CopyVector<2>(found.pixel, pixel);
    derivative = found.J_point * std::ldexp(1, shift);
  } else {
    CopyVector<2>({NAN, NAN}, pixel);
    derivative.setConstant(NAN);
  }
}

// ---- Pixels ----------------------------------------------------------------

// Returns two orthonormal directions perpendicular to a unit vector.
Eigen::Matrix<double, 3, 2> MakeTangentBasis(const Eigen::Vector3d& direction) {
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = direction.unitOrthogonal();
  across.col(1) = direction.cross(across.col(0));
  return across;
}

// Returns d pixel / d displacement, for a point on the line displaced
// perpendicularly to it.
Eigen::Matrix2d ComputeMotionJacobian(const CameraModel& camera,
                                      const ObservationLine& line,
                                      const Eigen::Matrix<double, 3, 2>& across,
                                      double distance,
                                      const Eigen::Vector2d& pixel) {
  constexpr double kRoundingPx = 1e-3;
  LinearizedProjection found;
  if (!camera.Linearize(line.origin + distance * line.direction, &pixel,
                        kRoundingPx, &found))
    return Eigen::Matrix2d::Constant(NAN);
  return found.J_point * across;
}

// Returns d direction / d pixel. A pixel's change moves all points of its line:
// the displacement at a distance of 1 is, for central cameras, that of the
// direction. The lines of other cameras are also translated, by the
// displacement at a distance of 0; the change of direction is then the
// difference of the displacements at distances of 2 and 1.
Eigen::Matrix<double, 3, 2> ComputeDirectionJacobian(
    const CameraModel& camera, bool is_central, const ObservationLine& line,
    const Eigen::Vector2d& pixel) {
  const Eigen::Matrix<double, 3, 2> across = MakeTangentBasis(line.direction);
  const Eigen::Matrix2d near =
      ComputeMotionJacobian(camera, line, across, 1, pixel).inverse();
  if (is_central) return across * near;
  return across *
         (ComputeMotionJacobian(camera, line, across, 2, pixel).inverse() -
          near);
}

void UnprojectPixel(const CameraModel& camera, const double* given,
                    double* direction) {
  const Eigen::Vector2d pixel(given[0], given[1]);
  const std::optional<Eigen::Vector3d> found = camera.Unproject(pixel);
  if (found && camera.IsInImageCircle(pixel))
    CopyVector<3>(*found, direction);
  else
    CopyVector<3>({NAN, NAN, NAN}, direction);
}

// Computes the Jacobian of the direction at a pixel; NaN without a direction.
void DeriveDirection(const CameraModel& camera, bool is_central,
                     const double* given, const double* direction,
                     double* by_pixel) {
  const Eigen::Vector2d pixel(given[0], given[1]);
  Eigen::Map<Eigen::Matrix<double, 3, 2, Eigen::RowMajor>> derivative(by_pixel);
  const auto line =
      std::isnan(direction[0]) ? std::nullopt : camera.Line(pixel);
  if (line)
    derivative = ComputeDirectionJacobian(
        camera, is_central,
        {line->origin, Eigen::Map<const Eigen::Vector3d>(direction)}, pixel);
  else
    derivative.setConstant(NAN);
}

}  // namespace

py::object Project(const PyCamera& self, const py::object& given,
                   bool with_jacobians, int num_threads) {
  const InputVectors points = ReadVectors(given, 3, "points");
  DoubleArray pixels = points.Like({2});
  DoubleArray jacobians = points.Like({2, 3});
  if (!with_jacobians) jacobians = DoubleArray(0);
  double* const pixel = pixels.mutable_data();
  double* const jacobian = with_jacobians ? jacobians.mutable_data() : nullptr;
  const CameraModel& camera = *self.file.camera;
  const bool is_central = camera.IsCentral();
  ParallelForRanges(points.count, num_threads, [&](size_t first, size_t end) {
    for (size_t k = first; k < end; ++k)
      ProjectPoint(camera, is_central, points[k], pixel + 2 * k,
                   jacobian ? jacobian + 6 * k : nullptr);
  });
  if (!with_jacobians) return pixels;
  return py::make_tuple(pixels, jacobians);
}

py::object Unproject(const PyCamera& self, const py::object& given,
                     bool with_jacobians, int num_threads) {
  const InputVectors pixels = ReadVectors(given, 2, "pixels");
  DoubleArray directions = pixels.Like({3});
  DoubleArray jacobians = with_jacobians ? pixels.Like({3, 2}) : DoubleArray(0);
  double* const direction = directions.mutable_data();
  double* const jacobian = with_jacobians ? jacobians.mutable_data() : nullptr;
  const CameraModel& camera = *self.file.camera;
  const bool is_central = camera.IsCentral();
  ParallelForRanges(pixels.count, num_threads, [&](size_t first, size_t end) {
    for (size_t k = first; k < end; ++k)
      UnprojectPixel(camera, pixels[k], direction + 3 * k);
    for (size_t k = first; jacobian && k < end; ++k)
      DeriveDirection(camera, is_central, pixels[k], direction + 3 * k,
                      jacobian + 6 * k);
  });
  if (!with_jacobians) return directions;
  return py::make_tuple(directions, jacobians);
}

py::tuple Rays(const PyCamera& self, const py::object& given, int num_threads) {
  const InputVectors pixels = ReadVectors(given, 2, "pixels");
  DoubleArray origins = pixels.Like({3}), directions = pixels.Like({3});
  double* const origin = origins.mutable_data();
  double* const direction = directions.mutable_data();
  const CameraModel& camera = *self.file.camera;
  const Eigen::Vector3d none(NAN, NAN, NAN);
  ParallelForRanges(pixels.count, num_threads, [&](size_t first, size_t end) {
    for (size_t k = first; k < end; ++k) {
      const Eigen::Vector2d pixel(pixels[k][0], pixels[k][1]);
      const auto line =
          camera.IsInImageCircle(pixel) ? camera.Line(pixel) : std::nullopt;
      CopyVector<3>(line ? line->origin : none, origin + 3 * k);
      CopyVector<3>(line ? line->direction.normalized() : none,
                    direction + 3 * k);
    }
  });
  return py::make_tuple(origins, directions);
}

}  // namespace raygrid
