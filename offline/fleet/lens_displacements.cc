#include "fleet/lens_displacements.h"

#include "camera/nearest_rotation.h"
#include "camera/turned_camera.h"

namespace raygrid {

PixelField DisplacementsOf(const CameraModel& reference,
                           const CameraModel& unit,
                           const std::vector<Eigen::Vector2d>& pixels) {
  const TurnedCamera turned(unit,
                            NearestRotation(reference, unit, reference.area()));
  PixelField values;
  for (const Eigen::Vector2d& pixel : pixels) {
    constexpr double kMarginPx = 50;
    const auto ray = turned.Unproject(pixel);
    const auto seen =
        ray ? reference.Project(*ray, &pixel, kMarginPx) : std::nullopt;
    values.push_back(seen ? std::optional<Eigen::Vector2d>(*seen - pixel)
                          : std::nullopt);
  }
  return values;
}

Eigen::VectorXd PolynomialsAt(const Area& area, const Eigen::Vector2d& pixel,
                              int degree) {
  const Eigen::Array2d place = 2 * (pixel - area.center()).array() /
                               Eigen::Array2d(area.width(), area.height());
  std::vector<Eigen::Array2d> values = {Eigen::Array2d::Ones(), place};
  for (int n = 1; n < degree; ++n)
    values.push_back(((2 * n + 1) * place * values[n] - n * values[n - 1]) /
                     (n + 1));
  Eigen::VectorXd products(NumPolynomials(degree));
  int k = 0;
  for (int sum = 0; sum <= degree; ++sum)
    for (int j = 0; j <= sum; ++j)
      products[k++] = values[sum - j].x() * values[j].y();
  return products;
}

}  // namespace raygrid
