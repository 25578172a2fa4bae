#include "camera/view_camera.h"

#include "camera/paired_jet.h"

namespace raygrid {
namespace {

template <typename T>
Eigen::Matrix<T, 2, 1> GetPixel(ViewProjection projection,
                                const Eigen::Matrix<T, 3, 1>& point,
                                const Eigen::Matrix<T, 4, 1>& parameters) {
  const Eigen::Matrix<T, 2, 1> plane = PlanePoint(projection, point);
  return {parameters[0] * plane.x() + parameters[2],
          parameters[1] * plane.y() + parameters[3]};
}

}  // namespace

const std::vector<std::string>& ViewCamera::ParameterNames() const {
  static const std::vector<std::string> names = {"fx", "fy", "cx", "cy"};
  return names;
}

std::optional<Eigen::Vector3d> ViewCamera::Unproject(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel)) return std::nullopt;
  const auto direction = PlaneDirection(
      projection_,
      (pixel - parameters_.tail<2>()).cwiseQuotient(parameters_.head<2>()));
  if (!direction) return std::nullopt;
  return direction->normalized();
}

std::optional<Eigen::Vector2d> ViewCamera::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* /*start*/,
    double margin_px) const {
  if (!ContainsDirection(projection_, point)) return std::nullopt;
  const Eigen::Vector2d pixel = GetPixel(projection_, point, parameters_);
  if (!area().Contains(pixel, margin_px)) return std::nullopt;
  return pixel;
}

bool ViewCamera::Linearize(const Eigen::Vector3d& point,
                           const Eigen::Vector2d* start, double margin_px,
                           LinearizedProjection* projection) const {
  const auto pixel = Project(point, start, margin_px);
  if (!pixel) return false;
  using Jet = PairedJet<7>;
  Eigen::Matrix<Jet, 4, 1> parameters;
  for (int k = 0; k < 4; ++k) parameters[k] = Jet(parameters_[k], k);
  Eigen::Matrix<Jet, 3, 1> at;
  for (int k = 0; k < 3; ++k) at[k] = Jet(point[k], 4 + k);
  const Eigen::Matrix<Jet, 2, 1> value = GetPixel(projection_, at, parameters);
  projection->pixel = *pixel;
  projection->num_global = 4;
  for (int row = 0; row < 2; ++row) {
    projection->J_global.row(row).head<4>() = value[row].v.head<4>();
    projection->J_point.row(row) = value[row].v.segment<3>(4);
  }
  return true;
}

}  // namespace raygrid
