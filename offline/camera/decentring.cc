#include "camera/decentring.h"

#include <algorithm>

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

Eigen::VectorXd DecentringPixels(const ParametricModel& lens,
                                 const Area& area) {
  const int first = FirstCommonParameter(lens);
  const double radius = CornerRadius(lens, area);
  const double moved_px = lens.Parameters()[first] * radius * radius;
  Eigen::VectorXd pixels = Eigen::VectorXd::Zero(lens.NumParameters());
  const std::vector<std::string>& names = lens.ParameterNames();
  for (size_t k = 0; k < names.size(); ++k)
    if (names[k] == "p1" || names[k] == "p2" || names[k] == "sx1" ||
        names[k] == "sy1")
      pixels[first + static_cast<Eigen::Index>(k)] = moved_px;
  return pixels;
}

}  // namespace raygrid
