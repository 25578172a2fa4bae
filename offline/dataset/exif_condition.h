#ifndef RAYGRID_DATASET_EXIF_CONDITION_H
#define RAYGRID_DATASET_EXIF_CONDITION_H

#include <optional>
#include <string>

#include "camera/camera_stack.h"

namespace raygrid {

/// The EXIF tag of a condition: "SubjectDistance" for a lens position,
/// "AmbientTemperature".
std::string ExifTagName(CameraCondition condition);

/// Reads the value of a condition from EXIF data in a PNG, JPEG or WebP file: 1
/// / distance in metres, 0 for infinity; or degrees Celsius. Nothing if absent
/// or marked as unknown. name is used in errors. Throws InputError like
/// ParseImageHeader().
std::optional<double> ExifCondition(const std::string& name,
                                    const std::string& bytes,
                                    CameraCondition condition);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_EXIF_CONDITION_H
