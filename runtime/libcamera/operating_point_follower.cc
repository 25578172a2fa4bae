#include "operating_point_follower.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "blob_layout.h"
#include "bytes.h"
#include "camera_error.h"

namespace raygrid {

OperatingPointFollower::OperatingPointFollower(rg_camera* camera)
    : camera_(camera) {
  if (const uint8_t* const stack =
          rg_find_section(camera->blob, RG_SECTION_STACK, 0))
    condition_ = static_cast<rg_operating_parameter>(
        rg_load_u16(stack + RG_STACK_CONDITION));
}

void OperatingPointFollower::Follow(const FrameInfo& info) {
  if (is_idle()) return;
  const std::optional<float> value =
      *condition_ == RG_OPERATING_PARAMETER_TEMPERATURE
          ? info.sensor_temperature_c
          : info.lens_position;
  if (!value || !std::isfinite(*value)) {
    ++counts_.num_missing;
    return;
  }
  FollowValue(*value);
}

void OperatingPointFollower::FollowValue(double value) {
  constexpr double kMost = 32767;  // limit of q16 values
  const double q16 = std::clamp(value, -kMost, kMost) * 65536;
  const rg_status status =
      rg_set_operating_point(camera_, static_cast<int32_t>(std::lround(q16)));
  if (status == RG_EXTRAPOLATED)
    ++counts_.outside;
  else if (status != RG_OK)
    throw CameraError(CameraExit::kBlob,
                      std::string("blob: ") + rg_status_text(status));
}

}  // namespace raygrid
