#ifndef RAYGRID_TOOLS_VIEW_IMPORT_H
#define RAYGRID_TOOLS_VIEW_IMPORT_H

#include <string>

#include "exchange/table_format.h"
#include "view_options.h"

namespace raygrid {

/// The places of a view's pixels in the camera's image, or the other way
/// around, and what the user says of them: their file does not.
struct ViewImport {
  std::string path, bytes;
  ViewWords view;  ///< as it was exported with
  bool is_reverse = false;
  std::string image_size;  ///< --image-size: of the camera's image; or ""
};

/// The rays of the camera's pixels. Throws InputError, naming the file, and
/// Error(kUsage), naming the option that is missing or does not suit.
RayTable ReadViewTableRays(const TableFormat& format, const ViewImport& import);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_VIEW_IMPORT_H
