#include "camera/nearest_rotation.h"

#include <Eigen/SVD>

namespace raygrid {

Eigen::Quaterniond ComputeNearestRotation(const CameraModel& target,
                                          const CameraModel& camera,
                                          const Area& area) {
  constexpr int kColumns = 15, kRows = 11;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int j = 0; j < kRows; ++j)
    for (int i = 0; i < kColumns; ++i) {
      const Eigen::Vector2d pixel =
          area.center() +
          Eigen::Vector2d(((i + 0.5) / kColumns - 0.5) * area.width(),
                          ((j + 0.5) / kRows - 0.5) * area.height());
      const auto from = camera.Unproject(pixel), to = target.Unproject(pixel);
      if (from && to) sum += *to * from->transpose();
    }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity();
  mirror(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  return Eigen::Quaterniond(svd.matrixU() * mirror * svd.matrixV().transpose());
}

}  // namespace raygrid
