#include "exchange/nearest_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "camera/central_generic.h"
#include "dataset/error.h"
#include "exchange/external_model_selection.h"

namespace raygrid {
namespace {

// A camera defined only by the directions of its pixels, for model fits and
// error computation.
class DirectionCamera : public CameraModel {
 public:
  DirectionCamera(const ImageSize& size, DirectionAtPixel direction)
      : CameraModel(size, WholeImage(size)), direction_(std::move(direction)) {}

  std::string Name() const override { return "directions"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<DirectionCamera>(image_size(), direction_);
  }
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override {
    if (!area().Contains(pixel)) return std::nullopt;
    const auto direction = direction_(pixel);
    if (!direction || !direction->allFinite() || !(direction->norm() > 0))
      return std::nullopt;
    return direction->normalized();
  }
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d&,
                                         const Eigen::Vector2d*,
                                         double) const override {
    return std::nullopt;
  }
  using CameraModel::Project;
  bool Linearize(const Eigen::Vector3d&, const Eigen::Vector2d*, double,
                 LinearizedProjection*) const override {
    return false;
  }
  Eigen::VectorXd Parameters() const override { return {}; }
  void SetParameters(const Eigen::VectorXd&) override {}

 private:
  DirectionAtPixel direction_;
};

}  // namespace

const ExternalModel& GetNearestGridModel() {
  static const ExternalModel external_model = {
      models::kCentralGeneric, models::kCentralGeneric, {}};
  return external_model;
}

ConvertedCamera FitNearestGrid(const ImageSize& size,
                               const DirectionAtPixel& direction,
                               const std::string& why,
                               std::vector<std::string>* warnings) {
  constexpr double kMaxRmsPx = 0.002, kMaxUndefinedFraction = 0.9;
  constexpr int kMinKnots = 12, kMaxKnots = 96;
  const DirectionCamera camera(size, direction);
  if (ComputeUndefinedFraction(camera) > kMaxUndefinedFraction)
    throw InputError(
        fmt::format("less than 10 % of the {} x {} image has a valid ray; "
                    "check parameters and image size",
                    size.width, size.height));
  ConvertedCamera lens = {&GetNearestGridModel(), size, {}};
  ModelFit fit;
  const Area image = WholeImage(size);
  const double longest = std::max(image.width(), image.height());
  for (int along = kMinKnots;; along += along / 2) {
    const auto points = [&](double extent) {
      return 3 + std::max(1, static_cast<int>(
                                 std::lround((along - 3) * extent / longest)));
    };
    lens.grid = std::make_shared<CentralGeneric>(FitCentralGeneric(
        camera, image, points(image.width()), points(image.height())));
    fit = ComputeModelFit(camera, nullptr, *lens.grid, *lens.external_model,
                          Eigen::Quaterniond::Identity());
    if (fit.rms_px < kMaxRmsPx || along + along / 2 > kMaxKnots) break;
  }
  warnings->push_back(
      fmt::format("{}: converted to central-generic with fit error {}", why,
                  FormatModelFit(fit)));
  return lens;
}

ConvertedCamera FitSkewedGrid(const ConvertedCamera& lens,
                              std::vector<std::string>* warnings) {
  const Area image = WholeImage(lens.size);
  const double shear = lens.skew_px / lens.Value("fy");
  const double cy =
      FromProgram(lens.external_model->origin, lens.size, {0, lens.Value("cy")})
          .y();
  const double widest = std::abs(shear) * (lens.size.height + std::abs(cy)) + 1;
  if (!(widest < lens.size.width))
    throw InputError(fmt::format(
        "camera matrix: a skew of {:g} px is out of range", lens.skew_px));
  ConvertedCamera straight = lens;
  straight.skew_px = 0;
  const auto made = MakeCameraModel(straight);
  // The shear moves pixels from outside the image into it, so the area is
  // widened.
  const auto wide = made->Parametric()->CloneWithArea(
      {image.x0 - widest, image.y0, image.x1 + widest, image.y1});
  return FitNearestGrid(
      lens.size,
      [&](const Eigen::Vector2d& pixel) {
        return wide->Unproject(
            {pixel.x() - shear * (pixel.y() - cy), pixel.y()});
      },
      fmt::format("a skew of {:g} px in the camera matrix is not supported",
                  lens.skew_px),
      warnings);
}

}  // namespace raygrid
