#include "exchange/radial_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <optional>

#include "dataset/error.h"
#include "exchange/nearest_grid.h"

namespace raygrid {
namespace {

// Returns the incidence angle for an ideal radius; nullopt if the radius
// exceeds the limit of the projection.
std::optional<double> ComputeAngle(RadialProjection projection, double radius) {
  const auto arc_sine = [](double sine, double factor) {
    return sine < 1 ? std::optional(factor * std::asin(sine)) : std::nullopt;
  };
  constexpr double kThobyLength = 1.47, kThobyAngle = 0.713;
  switch (projection) {
    case RadialProjection::kRectilinear:
      return std::atan(radius);
    case RadialProjection::kEquidistant:
      return radius < M_PI ? std::optional(radius) : std::nullopt;
    case RadialProjection::kEquisolid:
      return arc_sine(radius / 2, 2);
    case RadialProjection::kStereographic:
      return 2 * std::atan(radius / 2);
    case RadialProjection::kOrthographic:
      return arc_sine(radius, 1);
    default:
      return arc_sine(radius / kThobyLength, 1 / kThobyAngle);
  }
}

// Inverts the radial distortion: returns the root on the branch of an
// invertible model. Newton's method starts at the centre, where the slope is 1.
std::optional<double> ComputeIdealRadius(const std::array<double, 4>& c,
                                         double seen) {
  constexpr int kMaxSteps = 100;
  double r = 0;
  for (int k = 0; k < kMaxSteps; ++k) {
    const double value =
        r * (1 + r * (c[0] + r * (c[1] + r * (c[2] + r * c[3]))));
    const double slope =
        1 + r * (2 * c[0] + r * (3 * c[1] + r * (4 * c[2] + r * 5 * c[3])));
    if (!(slope > 1e-3)) return std::nullopt;
    const double step = (seen - value) / slope;
    // Limits the step so that it does not cross a fold of the model.
    r += std::clamp(step, -0.1, 0.1);
    if (std::abs(step) < 1e-13 * (1 + seen)) return r;
  }
  return std::nullopt;
}

// Converts the lens to a parametric camera. Its external model is stored until
// the program ends.
ConvertedCamera MakeNamedCamera(const std::string& name, const ImageSize& size,
                                const RadialModel& lens) {
  static std::mutex mutex;
  static std::map<std::pair<std::string, std::string>, ExternalModel>
      external_models;
  const bool is_pinhole = lens.projection == RadialProjection::kRectilinear;
  const std::string model =
      is_pinhole ? models::kOpenCv : models::kThinPrismFisheye;
  const std::lock_guard<std::mutex> lock(mutex);
  ExternalModel& external_model =
      external_models
          .try_emplace({name, model},
                       MakeExternalModel(name, model, {"k1", "k2"}))
          .first->second;
  external_model.max_supported_angle_rad = is_pinhole ? M_PI / 2 : M_PI;
  return {&external_model,
          size,
          {lens.focal_px.x(), lens.focal_px.y(), lens.center_px.x(),
           lens.center_px.y(), lens.coefficients[1], lens.coefficients[3]}};
}

}  // namespace

ExternalModel MakeRadialExternalModel(const std::string& name) {
  return {name, models::kCentralGeneric, {}};
}

ConvertedCamera MakeRadialCamera(const std::string& name, const ImageSize& size,
                                 const RadialModel& lens,
                                 std::vector<std::string>* warnings) {
  if (size == ImageSize{})
    throw InputError("missing image size; specify --image-size WxH");
  if (!(lens.focal_px.minCoeff() > 0))
    throw InputError("focal lengths must be positive");
  const std::array<double, 4>& c = lens.coefficients;
  const bool is_named = lens.projection == RadialProjection::kRectilinear ||
                        lens.projection == RadialProjection::kEquidistant;
  if (is_named && c[0] == 0 && c[2] == 0)
    return MakeNamedCamera(name, size, lens);
  return FitNearestGrid(
      size,
      [&](const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector3d> {
        const Eigen::Vector2d seen =
            (pixel - lens.center_px).cwiseQuotient(lens.focal_px);
        const double radius = seen.norm();
        if (radius == 0) return Eigen::Vector3d::UnitZ();
        const auto ideal = ComputeIdealRadius(c, radius);
        const auto angle =
            ideal ? ComputeAngle(lens.projection, *ideal) : std::nullopt;
        if (!angle) return std::nullopt;
        const Eigen::Vector2d side = seen * (std::sin(*angle) / radius);
        return Eigen::Vector3d(side.x(), side.y(), std::cos(*angle));
      },
      fmt::format("{} has no equivalent model", name), warnings);
}

}  // namespace raygrid
