#ifndef RAYGRID_FLEET_POPULATION_ESTIMATION_H
#define RAYGRID_FLEET_POPULATION_ESTIMATION_H

#include <optional>
#include <vector>

#include "camera/population_covariance.h"
#include "dataset/camera_file.h"

namespace raygrid {

/// Estimates the covariance of the units about their mean: principal directions
/// of their smooth displacements, less the predicted uncertainty in the units'
/// files, plus the uncertainty of the mean. The strongest directions come
/// first, with reproducible signs. Returns nullopt for fewer than 8 units, or
/// for units that do not differ.
std::optional<PopulationCovariance> EstimatePopulationCovariance(
    const CameraModel& mean, const std::vector<CameraFile>& units);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_POPULATION_ESTIMATION_H
