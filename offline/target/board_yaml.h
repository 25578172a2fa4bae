#ifndef RAYGRID_TARGET_BOARD_YAML_H
#define RAYGRID_TARGET_BOARD_YAML_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "dataset/pattern.h"

namespace raygrid {

/// The position of the boards on their pages or screens.
struct BoardPosition {
  double width_mm = 0, height_mm = 0;  ///< size of the page
  Eigen::Vector2d first_feature_mm;    ///< position from its top-left corner
};

/// Scale of a print relative to its nominal size. If x and y differ, squares
/// are not square: square_m is then the mean, and the boards' points are listed
/// explicitly.
struct PrintScale {
  double x = 1, y = 1;
};

/// Formats pattern.yaml without a page.
std::string MakeBoardsYaml(const std::vector<Board>& boards);

/// Formats pattern.yaml; the page is described with nominal lengths.
std::string MakeBoardsYaml(const std::vector<Board>& boards,
                           const BoardPosition& place, const PrintScale& scale);

/// Throws Error(kUsage) for invalid boards.
void RequirePossibleBoards(const std::vector<Board>& boards);

}  // namespace raygrid

#endif  // RAYGRID_TARGET_BOARD_YAML_H
