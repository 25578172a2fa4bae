/// Lenses by formulas written here, and files of other programs against them.
#ifndef RAYGRID_TESTS_LENSES_BY_FORMULA_H
#define RAYGRID_TESTS_LENSES_BY_FORMULA_H

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "exchange/format.h"

namespace raygrid {

using Numbers = std::vector<double>;

inline ExchangeContents Read(const std::string& text,
                             std::optional<ImageSize> size = {},
                             const std::string& external_model = "") {
  return ReadExchangeFile(nullptr, {"f", text, external_model, size});
}

// k1, k2, p1, p2, k3 to k6 as OpenCV has them.
inline Eigen::Vector2d Distorted(double x, double y, Numbers d) {
  d.resize(8, 0);
  const double r2 = x * x + y * y;
  const double g = (1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]))) /
                   (1 + r2 * (d[5] + r2 * (d[6] + r2 * d[7])));
  return {x * g + 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x),
          y * g + d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y};
}

// Pixels of a lens; k is fx, fy, cx, cy and perhaps a skew.
inline Eigen::Vector2d AtPixel(const Eigen::Vector2d& xy, const Numbers& k) {
  const double skew = k.size() > 4 ? k[4] : 0;
  return {k[0] * xy.x() + skew * xy.y() + k[2], k[1] * xy.y() + k[3]};
}

struct Lens {
  Numbers k, d;
  double xi = 0;
  Eigen::Vector2d Pinhole(const Eigen::Vector3d& p) const {
    return AtPixel(Distorted(p.x() / p.z(), p.y() / p.z(), d), k);
  }
  Eigen::Vector2d Fisheye(const Eigen::Vector3d& p) const {
    const double r = p.head<2>().norm(), theta = std::atan2(r, p.z()),
                 t2 = theta * theta;
    const double bent =
        theta * (1 + t2 * (d[0] + t2 * (d[1] + t2 * (d[2] + t2 * d[3]))));
    return AtPixel(p.head<2>() * (bent / r), k);
  }
  Eigen::Vector2d Omni(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d unit = p.normalized();
    return AtPixel(
        Distorted(unit.x() / (unit.z() + xi), unit.y() / (unit.z() + xi), d),
        k);
  }
};

using Formula = Eigen::Vector2d (Lens::*)(const Eigen::Vector3d&) const;

inline void ExpectLens(const InputCamera& read, const Lens& lens,
                       Formula formula, double tolerance_px = 1e-9) {
  const auto model = MakeCameraModel(read.lens);
  for (const double x : {-0.31, 0.02, 0.27})
    for (const double y : {-0.22, 0.01, 0.18}) {
      const Eigen::Vector3d point(x, y, 1.1);
      const auto seen = model->Project(point);
      ASSERT_TRUE(seen) << x << " " << y;
      EXPECT_LT((*seen - (lens.*formula)(point)).norm(), tolerance_px)
          << x << " " << y;
    }
}

inline const Lens kPinholeLens = {{410, 411.5, 322.5, 238},
                                  {-0.21, 0.06, 1e-3, -2e-3}};
inline const Lens kFisheyeLens = {{290, 291.5, 322.5, 238},
                                  {0.03, -0.01, 4e-3, -1e-3}};
inline const Lens kOmniLens = {
    {910, 911.5, 322.5, 238}, {-0.11, 0.05, 1e-3, -2e-3}, 1.25};
constexpr ImageSize kImage = {640, 480};

}  // namespace raygrid

#endif  // RAYGRID_TESTS_LENSES_BY_FORMULA_H
