/// Fits grids to cameras for which raygrid has no parametric model.
#ifndef RAYGRID_EXCHANGE_NEAREST_GRID_H
#define RAYGRID_EXCHANGE_NEAREST_GRID_H

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "exchange/external_model.h"

namespace raygrid {

/// Returns the direction (not normalized) of a pixel.
using DirectionAtPixel =
    std::function<std::optional<Eigen::Vector3d>(const Eigen::Vector2d&)>;

/// External model of grids that approximate other models.
const ExternalModel& GetNearestGridModel();

/// Fits a grid to the directions of pixels. A warning states the fit error and
/// the reason: "it has a skew of 2 px, which no lens of raygrid has". Throws
/// InputError if almost no pixel has a direction.
ConvertedCamera FitNearestGrid(const ImageSize& size,
                               const DirectionAtPixel& direction,
                               const std::string& why,
                               std::vector<std::string>* warnings);

/// Fits a grid to a camera whose camera matrix has a skew.
ConvertedCamera FitSkewedGrid(const ConvertedCamera& lens,
                              std::vector<std::string>* warnings);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_NEAREST_GRID_H
