#ifndef RAYGRID_TARGET_BOARD_YAML_H
#define RAYGRID_TARGET_BOARD_YAML_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "dataset/pattern.h"

namespace raygrid {

/// The places of the boards on their pages or screens.
struct BoardPlace {
  double width_mm = 0, height_mm = 0;  ///< of the page
  Eigen::Vector2d first_feature_mm;    ///< from its top-left corner
};

/// How many times larger a print came out than it was drawn. Where the two
/// differ, no square is square: square_m is then the mean, and the boards'
/// points are written out.
struct PrintScale {
  double x = 1, y = 1;
};

/// pattern.yaml without a page.
std::string BoardsYaml(const std::vector<Board>& boards);

/// pattern.yaml; what it says of the page is what was drawn.
std::string BoardsYaml(const std::vector<Board>& boards,
                       const BoardPlace& place, const PrintScale& scale);

/// Throws Error(kUsage) for boards that cannot be.
void RequirePossibleBoards(const std::vector<Board>& boards);

}  // namespace raygrid

#endif  // RAYGRID_TARGET_BOARD_YAML_H
