#ifndef RAYGRID_DATASET_IMAGE_TIMES_H
#define RAYGRID_DATASET_IMAGE_TIMES_H

#include <map>
#include <string>

namespace raygrid {

/// When images were taken, seconds from any instant, by name.
using ImageTimes = std::map<std::string, double>;

/// Reads a CSV with the columns image and time_s. Throws InputError for
/// malformed files, an image that stands there twice, and two images of one
/// time.
ImageTimes ReadImageTimes(const std::string& path);
/// The times in a file's text; path is used in errors.
ImageTimes ParseImageTimes(const std::string& path, const std::string& text);

/// The text of such a CSV.
std::string FormatImageTimes(const ImageTimes& times);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_IMAGE_TIMES_H
