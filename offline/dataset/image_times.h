#ifndef RAYGRID_DATASET_IMAGE_TIMES_H
#define RAYGRID_DATASET_IMAGE_TIMES_H

#include <map>
#include <string>

namespace raygrid {

/// Capture times of images in seconds, from any origin, by image name.
using ImageTimes = std::map<std::string, double>;

/// Reads a CSV with the columns image and time_s. Throws InputError for
/// malformed files, repeated images, and two images with equal times.
ImageTimes ReadImageTimes(const std::string& path);
/// Parses such a CSV; path is used in errors.
ImageTimes ParseImageTimes(const std::string& path, const std::string& text);

/// Formats such a CSV.
std::string FormatImageTimes(const ImageTimes& times);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_IMAGE_TIMES_H
