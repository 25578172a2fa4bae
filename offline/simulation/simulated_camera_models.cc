#include "simulation/simulated_camera_models.h"

#include <fmt/format.h>

#include <cmath>

#include "dataset/error.h"
#include "simulation/asymmetric_camera.h"
#include "simulation/noncentral_simulated_camera.h"
#include "simulation/simulated_camera.h"
#include "simulation/simulated_fisheye.h"

namespace raygrid {
namespace {

constexpr double kDegree = M_PI / 180;
constexpr double kPupilShiftM = 0.002;

Area WithMargin(const ImageSize& size, double margin_px) {
  return {-margin_px, -margin_px, size.width - 1 + margin_px,
          size.height - 1 + margin_px};
}

// Returns bumps of up to 1.5 px in an image 640 px wide.
std::vector<DistortionBump> Bumps(const ImageSize& size) {
  std::vector<DistortionBump> bumps = {{{0.23, 0.25}, {0.9, -0.5}, 90},
                                       {{0.75, 0.71}, {-0.7, 1.3}, 110},
                                       {{0.52, 0.12}, {0.4, 0.8}, 70},
                                       {{0.14, 0.83}, {-1.0, -0.6}, 100},
                                       {{0.88, 0.27}, {0.8, 0.4}, 80}};
  const double scale = size.width / 640.0;
  for (DistortionBump& bump : bumps) {
    bump.center = bump.center.cwiseProduct(
        Eigen::Vector2d(size.width - 1, size.height - 1));
    bump.displacement_px *= scale;
    bump.radius_px *= scale;
  }
  return bumps;
}

SimulatedFisheye Fisheye(const ImageSize& size, double view_angle,
                         double margin_px) {
  FisheyeParameters parameters;
  parameters.cx = (size.width - 1) / 2.0 + 0.004 * size.width;
  parameters.cy = (size.height - 1) / 2.0 - 0.003 * size.width;
  parameters.k1 = -0.03;
  parameters.k2 = 0.002;
  parameters.f_px = 1;
  parameters.f_px = size.width / 2.0 / parameters.Radius(view_angle / 2);
  return SimulatedFisheye(size, WithMargin(size, margin_px), parameters);
}

OpenCvModel Parametric(const ImageSize& size, double f_of_width, double k1,
                       double k2, double k4) {
  const double f_px = f_of_width * size.width;
  return OpenCvModel(
      size, WithMargin(size, 1),
      {f_px, 1.002 * f_px, size.width * 0.503 - 0.5, size.height * 0.495 - 0.5,
       k1, k2, 0, k4, 0, 0, 2e-4, -1e-4});
}

// Change of the intrinsics relative to 0 dioptres, or to 20 degrees Celsius.
struct IntrinsicsChange {
  double focal_fraction = 0, k1 = 0;
  Eigen::Vector2d center_px = {0, 0};
};

IntrinsicsChange ComputeTemperatureChange(double temperature) {
  const double part = (temperature - 20) / 50;
  return {-40e-6 * (temperature - 20), 0,
          part * (1.25 - 0.25 * part) * Eigen::Vector2d(0.4, -0.3)};
}

IntrinsicsChange ComputeLensPositionChange(double lens_position) {
  const double part = lens_position / 10;
  return {0.04 * part + 0.005 * part * (1 - part), 0.015 * part,
          part * Eigen::Vector2d(1.6, -0.9) +
              part * part * Eigen::Vector2d(0.3, 0.8)};
}

std::unique_ptr<CameraModel> WithBumps(std::shared_ptr<const CameraModel> lens,
                                       const ImageSize& size) {
  return std::make_unique<SimulatedCamera>(std::move(lens), WithMargin(size, 1),
                                           Bumps(size));
}

}  // namespace

std::unique_ptr<CameraModel> MakeSimulatedCamera(const std::string& name,
                                                 const ImageSize& size) {
  if (name == "pinhole")
    return Parametric(size, 0.785, -0.01, 0.002, 0).Clone();
  if (name == "wide") {
    const OpenCvModel lens = Parametric(size, 0.52, -0.02, 0.005, 0.18);
    return std::make_unique<SimulatedCamera>(lens, Bumps(size));
  }
  if (name == "fisheye") {
    // The area exceeds the image by more than the largest bump.
    const double margin_px = 1 + 0.01 * size.width;
    return WithBumps(std::make_shared<SimulatedFisheye>(
                         Fisheye(size, 145 * kDegree, margin_px)),
                     size);
  }
  if (name == "fisheye190") return Fisheye(size, 190 * kDegree, 1).Clone();
  if (name == "noncentral")
    return MovingPupilCamera(*MakeSimulatedCamera("fisheye", size),
                             kPupilShiftM)
        .Clone();
  if (name == "glass") {
    const SimulatedCamera lens(Parametric(size, 0.83, -0.28, 0.09, 0),
                               Bumps(size));
    return CoverGlassCamera(MovingPupilCamera(lens, kPupilShiftM), GlassPlate())
        .Clone();
  }
  if (name == "anamorphic")
    return AnamorphicCamera(size, WithMargin(size, 1)).Clone();
  if (name == "off-axis")
    return OffAxisCamera(size, WithMargin(size, 1)).Clone();
  if (name == "halves")
    return TwoFocalLengthsCamera(size, WithMargin(size, 1)).Clone();
  if (name == "decentred")
    return DecentredCamera(size, WithMargin(size, 1)).Clone();
  if (name == "mirror") return MirrorCamera(size, WithMargin(size, 1)).Clone();
  if (name == "example") {
    const SimulatedCamera example = ExampleSimulatedCamera();
    if (size != example.image_size())
      throw InputError("lens example: requires image size 640x480");
    return example.Clone();
  }
  throw InputError(fmt::format(
      "unknown lens '{}'; use pinhole, example, wide, fisheye, fisheye190, "
      "noncentral, glass, anamorphic, off-axis, halves, decentred or mirror",
      name));
}

std::unique_ptr<CameraModel> MakeVaryingCamera(
    const SimulatedOperatingPoint& state, const ImageSize& size) {
  const IntrinsicsChange near = ComputeLensPositionChange(state.lens_position);
  const IntrinsicsChange warm = ComputeTemperatureChange(state.temperature);
  OpenCvModel lens = Parametric(size, 0.83, -0.28 + near.k1 + warm.k1, 0.09, 0);
  Eigen::VectorXd parameters = lens.Parameters();
  parameters.head<2>() *= (1 + near.focal_fraction) * (1 + warm.focal_fraction);
  parameters.segment<2>(2) +=
      (near.center_px + warm.center_px) * size.width / 640;
  lens.SetParameters(parameters);
  return std::make_unique<SimulatedCamera>(lens, Bumps(size));
}

std::unique_ptr<CameraModel> MakeVaryingCamera(OperatingParameter condition,
                                               double value,
                                               const ImageSize& size) {
  SimulatedOperatingPoint state;
  if (condition == OperatingParameter::kLensPosition)
    state.lens_position = value;
  else
    state.temperature = value;
  return MakeVaryingCamera(state, size);
}

}  // namespace raygrid
