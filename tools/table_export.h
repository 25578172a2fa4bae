#ifndef RAYGRID_TOOLS_TABLE_EXPORT_H
#define RAYGRID_TOOLS_TABLE_EXPORT_H

#include <optional>
#include <string>
#include <vector>

#include "commands.h"
#include "exchange/table_format.h"
#include "view_options.h"

namespace raygrid {

struct TableArguments {
  std::string input, output;
  std::string model;
  std::string address;  ///< "0x08080000", or "" if not specified
  std::string every;    ///< "8", or ""
  std::optional<double> max_fit_error_px;
  ViewKeyValues view;
  bool is_reverse = false;               ///< inverse: sources in the view
  std::string pattern;                   ///< pattern of features.csv
  std::vector<std::string> image_sizes;  ///< "640x480" or "left=640x480"
};

/// Writes a table in a format for a blob, a view, rays, poses or features, and
/// reports it.
void ExportTable(const TableFormat& format, const TableArguments& arguments,
                 const CommonOptions& common);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_TABLE_EXPORT_H
