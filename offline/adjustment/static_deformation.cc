#include "adjustment/static_deformation.h"

#include <algorithm>

namespace raygrid {
namespace {

// Coordinates from a board's first to its last point; points of other boards in
// between are not affected.
struct Coordinates {
  int begin = 0, end = 0;
};

Coordinates FindBoardCoordinates(const DeformationModes& modes, int board) {
  const auto begin = modes.boards.begin(), end = modes.boards.end();
  const auto first = std::find(begin, end, board);
  if (first == end) return {};
  const auto last =
      std::find(modes.boards.rbegin(), modes.boards.rend(), board).base();
  return {3 * static_cast<int>(first - begin),
          3 * static_cast<int>(last - begin)};
}

}  // namespace

StaticDeformation::StaticDeformation(const ParameterLayout& layout,
                                     const DeformationModes& modes)
    : layout_(layout), moved_(layout) {
  if (!layout.has_shapes()) return;
  moved_.per_board = 0;
  moved_.first_point = moved_.first_shape;
  moved_.num_points = static_cast<int>(modes.by_point.size());
  moved_.size = moved_.Point(moved_.num_points);
  for (int b = 0; b < modes.num_boards(); ++b) {
    const Coordinates range = FindBoardCoordinates(modes, b);
    Eigen::MatrixXd J_coordinate =
        Eigen::MatrixXd::Zero(range.end - range.begin, modes.count());
    for (int i = range.begin; i < range.end; i += 3)
      if (modes.boards[i / 3] == b)
        J_coordinate.middleRows<3>(i - range.begin) = modes.by_point[i / 3];
    boards_.push_back({layout.Shape(b), range.begin, std::move(J_coordinate)});
  }
}

CoarseBasis StaticDeformation::MapToPoints(const CoarseBasis& basis) const {
  if (boards_.empty()) return basis;
  std::vector<Eigen::Triplet<double>> triplets;
  const auto add = [&](int from, int to, double weight) {
    for (CoarseBasis::InnerIterator it(basis, from); it && weight != 0; ++it)
      triplets.emplace_back(to, it.col(), weight * it.value());
  };
  for (int i = 0; i < layout_.first_shape; ++i) add(i, i, 1);
  for (int i = 0; i < 3 * layout_.num_points; ++i)
    add(layout_.first_point + i, moved_.first_point + i, 1);
  for (const Board& board : boards_)
    for (int i = 0; i < board.modes.rows(); ++i)
      for (int k = 0; k < board.modes.cols(); ++k)
        add(board.shape + k, moved_.first_point + board.first + i,
            board.modes(i, k));
  CoarseBasis moved(moved_.size, basis.cols());
  moved.setFromTriplets(triplets.begin(), triplets.end());
  return moved;
}

}  // namespace raygrid
