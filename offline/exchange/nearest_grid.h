/// Lenses that no model of raygrid has, as the grids nearest to them.
#ifndef RAYGRID_EXCHANGE_NEAREST_GRID_H
#define RAYGRID_EXCHANGE_NEAREST_GRID_H

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "exchange/lens_form.h"

namespace raygrid {

/// The direction, of any length, that a pixel of an image looks along.
using DirectionAtPixel =
    std::function<std::optional<Eigen::Vector3d>(const Eigen::Vector2d&)>;

/// The form of grids that stand for other lenses.
const LensForm& NearestGridForm();

/// The grid nearest to what pixels look along. A remark says why, "it has a
/// skew of 2 px, which no lens of raygrid has", and the error that is left.
/// Throws InputError if hardly a pixel looks anywhere.
ConvertedLens FitNearestGrid(const ImageSize& size,
                             const DirectionAtPixel& direction,
                             const std::string& why,
                             std::vector<std::string>* warnings);

/// That of a lens whose camera matrix has a skew.
ConvertedLens FitSkewedGrid(const ConvertedLens& lens,
                            std::vector<std::string>* warnings);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_NEAREST_GRID_H
