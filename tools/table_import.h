#ifndef RAYGRID_TOOLS_TABLE_IMPORT_H
#define RAYGRID_TOOLS_TABLE_IMPORT_H

#include <string>
#include <vector>

#include "commands.h"
#include "dataset/pattern.h"
#include "exchange/table_format.h"
#include "import_arguments.h"

namespace raygrid {

/// The format of a table that is imported alone; null if the first of the texts
/// is no table. Throws Error for what does not suit a table.
const TableFormat* FindTable(const ImportArguments& arguments,
                             const std::vector<std::string>& texts);

/// Throws Error(kUsage) for options that only tables of a view take.
void RequireNoView(const ImportArguments& arguments);

/// Writes what a table becomes, and tells it: a camera, poses, features or
/// boards. Throws Error.
void ImportTable(const TableFormat& table, const ImportArguments& arguments,
                 const std::string& bytes, const CommonOptions& common);

/// The text of pattern.yaml. Throws InputError, naming the file, for a board
/// that cannot be.
std::string PatternText(const std::string& path,
                        const std::vector<Board>& boards);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_TABLE_IMPORT_H
