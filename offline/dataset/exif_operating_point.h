#ifndef RAYGRID_DATASET_EXIF_OPERATING_POINT_H
#define RAYGRID_DATASET_EXIF_OPERATING_POINT_H

#include <optional>
#include <string>

#include "camera/operating_point_model.h"

namespace raygrid {

/// The EXIF tag of a condition: "SubjectDistance" for a lens position,
/// "AmbientTemperature".
std::string ExifTagName(OperatingParameter condition);

/// Reads the value of a condition from EXIF data in a PNG, JPEG or WebP file: 1
/// / distance in metres, 0 for infinity; or degrees Celsius. Nothing if absent
/// or marked as unknown. name is used in errors. Throws InputError like
/// ParseImageHeader().
std::optional<double> ReadExifParameter(const std::string& name,
                                        const std::string& bytes,
                                        OperatingParameter condition);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_EXIF_OPERATING_POINT_H
