#ifndef RAYGRID_REPORT_THUMBNAILS_H
#define RAYGRID_REPORT_THUMBNAILS_H

#include <map>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "report/page_data.h"

namespace raygrid {

/// Small grey JPEG files of images, by their names.
using Thumbnails = std::map<std::string, std::string>;

/// The thumbnails of a dataset's images, whose files these are: the more there
/// are the smaller each, at most 3 MB together. Files that cannot be read any
/// more are left out.
Thumbnails MakeThumbnails(const Dataset& dataset,
                          const std::vector<std::string>& paths,
                          int num_threads);

/// thumbnails.json: {"raygrid_thumbnails": 1, "images": {name: Base64}}.
std::string FormatThumbnails(const Thumbnails& thumbnails);
/// The thumbnails by name, in Base64. Throws InputError naming the file.
ThumbnailTexts ParseThumbnails(const std::string& path,
                               const std::string& json);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_THUMBNAILS_H
