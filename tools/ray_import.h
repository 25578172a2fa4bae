#ifndef RAYGRID_TOOLS_RAY_IMPORT_H
#define RAYGRID_TOOLS_RAY_IMPORT_H

#include <string>

#include "commands.h"
#include "exchange/table_format.h"

namespace raygrid {

/// Writes the grid camera of a table of rays, and tells the error it leaves.
/// The table is of the format; model is one of FitRayGrid().
void ImportRays(const RayTable& rays, const std::string& format,
                const std::string& model, const std::string& output,
                const CommonOptions& common);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_RAY_IMPORT_H
