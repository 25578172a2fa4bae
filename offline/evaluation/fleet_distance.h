#ifndef RAYGRID_EVALUATION_FLEET_DISTANCE_H
#define RAYGRID_EVALUATION_FLEET_DISTANCE_H

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "camera/camera_uncertainty.h"
#include "camera/population_covariance.h"

namespace raygrid {

/// The distance of a camera from a fleet's population mean, compared with the
/// spread of the fleet's units.
struct FleetDistance {
  double rms_px = 0;    ///< a lower bound for far outliers
  double units_px = 0;  ///< expected for a unit, including the camera's errors

  /// Returns whether the camera is an outlier of the fleet.
  bool IsOutlier() const;
  /// Formats "4.1 px RMS from the population mean at the features, compared
  /// with 0.3 px for the units of the fleet".
  std::string Text() const;
  /// Formats Text() for an outlier, with a recommendation.
  std::string Warning() const;
};

/// Computes RMS distances over a sample of the camera's pixels, after the
/// rotation that best aligns the camera with the mean. The variances of the
/// camera (standard deviations per axis in `deviations`) are added to those of
/// the units. Returns nullopt if no pixel is in the area of the mean camera.
std::optional<FleetDistance> MeasureFleetDistance(
    const CameraModel& mean, const PopulationCovariance& spread,
    const CameraModel& camera, const UncertaintyLattice* deviations,
    const std::vector<Eigen::Vector2d>& pixels);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_FLEET_DISTANCE_H
