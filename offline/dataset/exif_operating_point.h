#ifndef RAYGRID_DATASET_EXIF_OPERATING_POINT_H
#define RAYGRID_DATASET_EXIF_OPERATING_POINT_H

#include <optional>
#include <string>

#include "camera/operating_point_model.h"

namespace raygrid {

/// Returns the EXIF tag of an operating-point variable: "SubjectDistance" for a
/// lens position, "AmbientTemperature".
std::string ExifTagName(OperatingParameter condition);

/// Reads an operating-point variable from the EXIF data of a PNG, JPEG or WebP
/// file: 1 / distance in metres, 0 for infinity; or degrees Celsius. nullopt if
/// absent or marked as unknown. name is used in errors. Throws InputError like
/// ParseImageHeader().
std::optional<double> ReadExifParameter(const std::string& name,
                                        const std::string& bytes,
                                        OperatingParameter condition);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_EXIF_OPERATING_POINT_H
