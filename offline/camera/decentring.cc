#include "camera/decentring.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace raygrid {

int FirstCommonParameter(const ParametricModel& lens) {
  return lens.NumParameters() - static_cast<int>(lens.ParameterNames().size());
}

double CornerRadius(const ParametricModel& lens, const Area& area) {
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

Eigen::VectorXd RadialPixels(const ParametricModel& lens, const Area& area) {
  const int first = FirstCommonParameter(lens);
  const double radius = CornerRadius(lens, area);
  const std::vector<int> orders = lens.RadialOrders();
  Eigen::VectorXd pixels = Eigen::VectorXd::Zero(lens.NumParameters());
  for (size_t k = 0; k < orders.size(); ++k)
    if (orders[k] != 0)
      pixels[first + static_cast<Eigen::Index>(k)] =
          lens.Parameters()[first] * std::pow(radius, orders[k]);
  return pixels;
}

Eigen::VectorXd DecentringPixels(const ParametricModel& lens,
                                 const Area& area) {
  // The order of the radius that a unit of each moves an image by.
  static const std::map<std::string, int> orders = {
      {"p1", 2}, {"p2", 2}, {"sx1", 2}, {"sy1", 2}, {"s1", 2},
      {"s2", 4}, {"s3", 2}, {"s4", 4},  {"tx", 2},  {"ty", 2}};
  const int first = FirstCommonParameter(lens);
  const double radius = CornerRadius(lens, area);
  Eigen::VectorXd pixels = Eigen::VectorXd::Zero(lens.NumParameters());
  const std::vector<std::string>& names = lens.ParameterNames();
  for (size_t k = 0; k < names.size(); ++k) {
    const auto order = orders.find(names[k]);
    if (order != orders.end())
      pixels[first + static_cast<Eigen::Index>(k)] =
          lens.Parameters()[first] * std::pow(radius, order->second);
  }
  return pixels;
}

}  // namespace raygrid
