#ifndef RAYGRID_ADJUSTMENT_ADJUSTMENT_STATE_H
#define RAYGRID_ADJUSTMENT_ADJUSTMENT_STATE_H

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "camera/camera_model.h"
#include "camera/pose.h"

namespace raygrid {

/// A pattern point seen at a pixel.
struct Observation {
  int point = 0;
  Eigen::Vector2d pixel;
};

/// The observations of one board in one image.
struct View {
  std::vector<Observation> observations;
};

/// What bundle adjustment changes. Copies are deep.
struct AdjustmentState {
  std::unique_ptr<CameraModel> camera;
  std::vector<Pose> camera_from_pattern;  ///< one a view
  std::vector<Eigen::Vector3d> points;    ///< in the pattern's frame

  AdjustmentState() = default;
  AdjustmentState(AdjustmentState&&) = default;
  AdjustmentState& operator=(AdjustmentState&&) = default;
  AdjustmentState(const AdjustmentState& other) { *this = other; }
  AdjustmentState& operator=(const AdjustmentState& other) {
    camera = other.camera ? other.camera->Clone() : nullptr;
    camera_from_pattern = other.camera_from_pattern;
    points = other.points;
    return *this;
  }
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_ADJUSTMENT_STATE_H
