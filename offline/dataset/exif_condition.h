#ifndef RAYGRID_DATASET_EXIF_CONDITION_H
#define RAYGRID_DATASET_EXIF_CONDITION_H

#include <optional>
#include <string>

#include "camera/camera_stack.h"

namespace raygrid {

/// The tag of EXIF that tells a condition: "SubjectDistance" of a lens
/// position, "AmbientTemperature".
std::string ExifTagName(CameraCondition condition);

/// The value of a condition in the EXIF data of a photograph's file, PNG, JPEG
/// or WebP: 1 / the distance in metres, 0 for infinity, or degrees Celsius.
/// Nothing if they do not tell it, or say that it is not known. name is used in
/// errors. Throws InputError as ParseImageHeader() does.
std::optional<double> ExifCondition(const std::string& name,
                                    const std::string& bytes,
                                    CameraCondition condition);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_EXIF_CONDITION_H
