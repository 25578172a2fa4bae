#ifndef RAYGRID_TOOLS_VIEW_IMPORT_H
#define RAYGRID_TOOLS_VIEW_IMPORT_H

#include <string>

#include "exchange/table_format.h"
#include "view_options.h"

namespace raygrid {

/// A remap table of a view, or its inverse, and what the user specifies because
/// the file does not contain it.
struct ViewImport {
  std::string path, bytes;
  ViewKeyValues view;  ///< options with which it was exported
  bool is_reverse = false;
  std::string image_size;  ///< --image-size of the camera's image, or ""
};

/// Computes rays of the camera's pixels from the table. Throws InputError, with
/// the file name, and Error(kUsage), with the missing or invalid option.
RayTable ReadViewTableRays(const TableFormat& format, const ViewImport& import);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_VIEW_IMPORT_H
