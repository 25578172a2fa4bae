#ifndef RAYGRID_HOST_LIBRARY_EVALUATOR_H
#define RAYGRID_HOST_LIBRARY_EVALUATOR_H

#include <memory>

#include "camera/camera_model.h"
#include "host_library/chart.h"

namespace raygrid::host {

/// Columns of a matrix: x, y of pixels, or x, y, z.
template <typename Number>
struct Columns {
  Number* data = nullptr;
  Eigen::Index stride = 0;  ///< from a column to the next

  Number* operator[](int k) const { return data + k * stride; }
};

/// Computes what Camera offers, for one kind of camera models. Results are
/// those of the CameraModel: functions that return bool return whether they are
/// defined, and J may be null.
template <typename Scalar>
class Evaluator {
 public:
  virtual ~Evaluator() = default;

  /// The evaluator of the model with other parameters; initial values are
  /// reused.
  virtual std::shared_ptr<const Evaluator> WithModel(
      std::shared_ptr<const CameraModel> model) const = 0;

  virtual bool Unproject(const Vec2<Scalar>& pixel, Vec3<Scalar>* bearing,
                         Mat32<Scalar>* J_pixel) const = 0;
  virtual bool UnprojectLine(const Vec2<Scalar>& pixel, Vec3<Scalar>* origin,
                             Vec3<Scalar>* bearing, Mat32<Scalar>* origin_J,
                             Mat32<Scalar>* bearing_J) const = 0;
  virtual bool Project(const Vec3<Scalar>& point, Vec2<Scalar>* pixel,
                       Mat23<Scalar>* J_point) const = 0;

  /// Return the number of defined results, others are NaN. origins may have no
  /// data.
  virtual int UnprojectAll(Columns<const Scalar> pixels, int count,
                           Columns<Scalar> origins,
                           Columns<Scalar> bearings) const = 0;
  virtual int ProjectAll(Columns<const Scalar> points, int count,
                         Columns<Scalar> pixels) const = 0;
};

/// Creates the evaluator for a camera model of any type.
template <typename Scalar>
std::shared_ptr<const Evaluator<Scalar>> MakeEvaluator(
    std::shared_ptr<const CameraModel> model);

}  // namespace raygrid::host

#endif  // RAYGRID_HOST_LIBRARY_EVALUATOR_H
