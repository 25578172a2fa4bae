#include "exchange/skewed_lens.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "camera/camera_wrapper.h"
#include "camera/central_generic.h"
#include "dataset/error.h"
#include "exchange/lens_choice.h"

namespace raygrid {
namespace {

// A lens whose images are sheared: x grows by a part of how far y lies from the
// principal point.
class SkewedLens : public CameraWrapper {
 public:
  SkewedLens(const CameraModel& lens, const Area& area, double shear, double cy)
      : CameraWrapper(lens, lens.image_size(), area), shear_(shear), cy_(cy) {}

  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<SkewedLens>(camera(), area(), shear_, cy_);
  }
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override {
    if (!area().Contains(pixel)) return std::nullopt;
    return camera().Unproject({pixel.x() - Shift(pixel.y()), pixel.y()});
  }
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* /*start*/,
                                         double margin_px) const override {
    const auto straight = camera().Project(point, nullptr, margin_px);
    if (!straight) return std::nullopt;
    return Eigen::Vector2d(straight->x() + Shift(straight->y()), straight->y());
  }
  using CameraModel::Project;
  bool Linearize(const Eigen::Vector3d&, const Eigen::Vector2d*, double,
                 LinearizedProjection*) const override {
    return false;  // it is fitted by its directions alone
  }

 private:
  double Shift(double y) const { return shear_ * (y - cy_); }

  double shear_, cy_;
};

}  // namespace

LensInForm GridOfSkewedLens(const LensInForm& lens,
                            std::vector<std::string>* remarks) {
  constexpr double kNearEnoughPx = 0.002;
  constexpr int kFewest = 12, kMost = 96;
  static const LensForm form = {"central-generic", "central-generic", {}};
  const Area image = WholeImage(lens.size);
  const double shear = lens.skew_px / lens.Value("fy");
  const double cy =
      FromProgram(lens.form->origin, lens.size, {0, lens.Value("cy")}).y();
  const double widest = std::abs(shear) * (lens.size.height + std::abs(cy)) + 1;
  if (!(widest < lens.size.width))
    throw InputError(fmt::format(
        "camera matrix: a skew of {:g} px leaves nothing of the image",
        lens.skew_px));
  LensInForm straight = lens;
  straight.skew_px = 0;
  const auto made = MakeLens(straight);
  const auto& parametric = dynamic_cast<const ParametricModel&>(*made);
  const Area wide = {image.x0 - widest, image.y0, image.x1 + widest, image.y1};
  const SkewedLens skewed(*parametric.OverArea(wide), image, shear, cy);
  LensInForm grid = {&form, lens.size, {}};
  LensFit fit;
  const double longest = std::max(image.width(), image.height());
  for (int along = kFewest;; along += along / 2) {
    const auto points = [&](double extent) {
      return 3 + std::max(1, static_cast<int>(
                                 std::lround((along - 3) * extent / longest)));
    };
    grid.grid = std::make_shared<CentralGeneric>(FitCentralGeneric(
        skewed, image, points(image.width()), points(image.height())));
    fit = MeasureLens(skewed, nullptr, *grid.grid, form,
                      Eigen::Quaterniond::Identity());
    if (fit.rms_px < kNearEnoughPx || along + along / 2 > kMost) break;
  }
  remarks->push_back(fmt::format(
      "its camera matrix has a skew of {:g} px, which no lens of raygrid has: "
      "it is read as the nearest grid, which leaves {}",
      lens.skew_px, LensFitText(fit)));
  return grid;
}

}  // namespace raygrid
