#ifndef RAYGRID_TOOLS_RAY_IMPORT_H
#define RAYGRID_TOOLS_RAY_IMPORT_H

#include <string>

#include "commands.h"
#include "exchange/table_format.h"

namespace raygrid {

/// Fits a grid camera to a table of rays, writes it, and reports the fit error.
/// format: name of the table's format; model: see FitRayGrid().
void ImportRays(const RayTable& rays, const std::string& format,
                const std::string& model, const std::string& output,
                const CommonOptions& common);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_RAY_IMPORT_H
