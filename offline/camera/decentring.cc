#include "camera/decentring.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace raygrid {

namespace {

// Returns the displacement in pixels of the farthest corner per unit of each
// parameter whose order has this sign: positive for radial, negative for
// decentring parameters.
Eigen::VectorXd ListCornerPixels(const ParametricModel& lens, const Area& area,
                                 int sign) {
  const int first = FirstCommonParameter(lens);
  const double radius = ComputeCornerRadius(lens, area);
  const std::vector<int> orders = lens.DistortionOrders();
  Eigen::VectorXd pixels = Eigen::VectorXd::Zero(lens.NumParameters());
  for (size_t k = 0; k < orders.size(); ++k)
    if (sign * orders[k] > 0)
      pixels[first + static_cast<Eigen::Index>(k)] =
          lens.Parameters()[first] * std::pow(radius, sign * orders[k]);
  return pixels;
}

}  // namespace

int FirstCommonParameter(const ParametricModel& lens) {
  return lens.NumParameters() - static_cast<int>(lens.ParameterNames().size());
}

double ComputeCornerRadius(const ParametricModel& lens, const Area& area) {
  const Eigen::Vector4d common =
      lens.Parameters().segment<4>(FirstCommonParameter(lens));
  double radius = 0;
  for (const double x : {area.x0, area.x1})
    for (const double y : {area.y0, area.y1})
      radius =
          std::max(radius, (Eigen::Vector2d(x, y) - common.tail<2>()).norm() /
                               common[0]);
  return radius;
}

Eigen::VectorXd ComputeRadialDisplacement(const ParametricModel& lens,
                                          const Area& area) {
  return ListCornerPixels(lens, area, 1);
}

Eigen::VectorXd ComputeDecentringDisplacement(const ParametricModel& lens,
                                              const Area& area) {
  return ListCornerPixels(lens, area, -1);
}

}  // namespace raygrid
