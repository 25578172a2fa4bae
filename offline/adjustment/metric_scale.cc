#include "adjustment/metric_scale.h"

#include <Eigen/Geometry>
#include <cmath>

namespace raygrid {

double AlignToNominal(int first, const std::vector<Eigen::Vector3d>& nominal,
                      const std::vector<int>& poses, AdjustmentState* state) {
  const Eigen::Index count = static_cast<Eigen::Index>(nominal.size());
  Eigen::Matrix3Xd from(3, count), to(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    from.col(i) = state->points[first + i];
    to.col(i) = nominal[i];
  }
  // nominal = s R point + t. Lines that do not meet in a point have a scale.
  const bool scale_is_free = state->camera().IsCentral();
  const Eigen::Matrix4d similarity = Eigen::umeyama(from, to, scale_is_free);
  const double s = std::cbrt(similarity.topLeftCorner<3, 3>().determinant());
  const Eigen::Quaterniond r(
      Eigen::Matrix3d(similarity.topLeftCorner<3, 3>() / s));
  const Eigen::Vector3d t = similarity.topRightCorner<3, 1>();
  for (Eigen::Index i = 0; i < count; ++i)
    state->points[first + i] = s * (r * state->points[first + i]) + t;
  // s (Q p + u) = Q R^-1 (s R p + t) + s u - Q R^-1 t
  for (const int index : poses) {
    Pose& pose = state->rig_from_pattern[index];
    pose.rotation = (pose.rotation * r.inverse()).normalized();
    pose.translation = s * pose.translation - pose.rotation * t;
  }
  return s;
}

}  // namespace raygrid
