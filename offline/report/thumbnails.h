#ifndef RAYGRID_REPORT_THUMBNAILS_H
#define RAYGRID_REPORT_THUMBNAILS_H

#include <map>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "report/page_data.h"

namespace raygrid {

/// Grey JPEG thumbnails, by image name.
using Thumbnails = std::map<std::string, std::string>;

/// Makes thumbnails of a dataset's images from their files: at most 3 MB
/// together, thus smaller with more images. Unreadable files are omitted.
Thumbnails MakeThumbnails(const Dataset& dataset,
                          const std::vector<std::string>& paths,
                          int num_threads);

/// Formats thumbnails.json: {"raygrid_thumbnails": 1, "images": {name: ...}}.
std::string FormatThumbnails(const Thumbnails& thumbnails);
/// Reads thumbnails by name, in Base64. Throws InputError, with the file name.
ThumbnailTexts ParseThumbnails(const std::string& path,
                               const std::string& json);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_THUMBNAILS_H
