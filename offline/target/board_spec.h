/// Specifications of boards as short strings, as an alternative to
/// pattern.yaml.
#ifndef RAYGRID_TARGET_BOARD_SPEC_H
#define RAYGRID_TARGET_BOARD_SPEC_H

#include <string>

#include "dataset/pattern.h"

namespace raygrid {

/// Parses a specification of the board that `raygrid pattern KIND` would make:
///
///     KIND:COLUMNSxROWS:LENGTH[:NAME=VALUE]...
///
///     chessboard:9x6:25mm                     inner corners; side of a square
///     charuco:8x5:28mm:marker=21mm            likewise
///     aprilgrid:6x6:24mm                      tags; side of a tag's black
///     star:16x23:11.132mm                     stars; distance between them
///
/// A LENGTH is a number with mm, cm or m. NAMEs are the command's options,
/// which each kind in dataset/kinds adds; marker is a LENGTH, and flags have no
/// value. Throws Error(kUsage).
Pattern ParseBoardSpec(const std::string& spec);

/// Whether the string contains a colon and is not an existing file.
bool IsBoardSpec(const std::string& path_or_spec);

/// Reads pattern.yaml or parses a spec. Throws Error(kUsage), InputError.
Pattern ReadPatternOrSpec(const std::string& path_or_spec);

}  // namespace raygrid

#endif  // RAYGRID_TARGET_BOARD_SPEC_H
