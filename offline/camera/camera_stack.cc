#include "camera/camera_stack.h"

#include <utility>

namespace raygrid {

std::string ConditionName(CameraCondition condition) {
  return condition == CameraCondition::kLensPosition ? "lens_position"
                                                     : "temperature";
}

std::string ConditionUnit(CameraCondition condition) {
  return condition == CameraCondition::kLensPosition ? "dioptres" : "°C";
}

CameraStack::CameraStack(CameraCondition condition, double low, double high,
                         const ImageSize& image_size,
                         std::vector<BSplineSurface> terms)
    : condition_(condition),
      low_(low),
      high_(high),
      image_size_(image_size),
      terms_(std::move(terms)) {}

CameraStack::CameraStack(CameraCondition condition, double low, double high,
                         const CentralGeneric& camera, int order)
    : CameraStack(condition, low, high, camera.image_size(),
                  {camera.surface()}) {
  const BSplineSurface& surface = camera.surface();
  terms_.resize(order + 1, BSplineSurface(surface.area(), surface.columns(),
                                          surface.rows()));
}

std::vector<double> CameraStack::Powers(double value) const {
  const double t = (value - middle()) / ((high_ - low_) / 2);
  std::vector<double> powers = {1};
  while (powers.size() < terms_.size()) powers.push_back(powers.back() * t);
  return powers;
}

CentralGeneric CameraStack::At(double value) const {
  const std::vector<double> powers = Powers(value);
  BSplineSurface surface = terms_.front();
  for (size_t j = 1; j < terms_.size(); ++j)
    for (int k = 0; k < surface.num_points(); ++k)
      surface.points()[k] += powers[j] * terms_[j].points()[k];
  return CentralGeneric(image_size_, std::move(surface));
}

}  // namespace raygrid
