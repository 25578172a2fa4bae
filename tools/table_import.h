#ifndef RAYGRID_TOOLS_TABLE_IMPORT_H
#define RAYGRID_TOOLS_TABLE_IMPORT_H

#include <string>
#include <vector>

#include "commands.h"
#include "dataset/pattern.h"
#include "exchange/table_format.h"
#include "import_arguments.h"

namespace raygrid {

/// Returns the format of a table that is imported alone; NULL if the first text
/// is not a table. Throws Error for arguments that are invalid for tables.
const TableFormat* SelectTable(const ImportArguments& arguments,
                               const std::vector<std::string>& texts);

/// Throws Error(kUsage) for options that are valid only for tables of a view.
void RequireNoView(const ImportArguments& arguments);

/// Converts a table to a camera, poses, features or boards, writes and reports
/// it. Throws Error.
void ImportTable(const TableFormat& table, const ImportArguments& arguments,
                 const std::string& bytes, const CommonOptions& common);

/// Formats pattern.yaml. Throws InputError, with the file name, for an invalid
/// board.
std::string PatternText(const std::string& path,
                        const std::vector<Board>& boards);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_TABLE_IMPORT_H
