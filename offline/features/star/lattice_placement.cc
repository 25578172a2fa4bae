#include "features/star/lattice_placement.h"

#include <algorithm>

#include "features/star/loose_lattice.h"

namespace raygrid {
namespace {

// Maximum fractions of stars at board positions without a star: on tags, and
// outside the board, where paper may resemble half of a star with few segments.
constexpr double kMaxFractionOnTags = 0.2, kMaxFractionOutside = 0.4;

// Rotates (column, row) by multiples of 90 degrees, clockwise on the board.
Eigen::Vector2d RotateByQuarterTurns(int quarter_turns,
                                     const Eigen::Vector2d& p) {
  switch (quarter_turns & 3) {
    case 0:
      return p;
    case 1:
      return {-p.y(), p.x()};
    case 2:
      return -p;
    default:
      return {p.y(), -p.x()};
  }
}

bool FitsOnBoard(const LatticePlacement& placement,
                 const std::vector<Feature>& stars, const Board& board) {
  const auto limit = [&](double part) {
    return std::max(1, static_cast<int>(part * stars.size()));
  };
  int num_on_tags = 0, num_beyond = 0;
  for (const Feature& star : stars) {
    const Eigen::Vector2i p = placement.OnBoard(star.column, star.row);
    if (p.x() < 0 || p.y() < 0 || p.x() >= board.columns || p.y() >= board.rows)
      ++num_beyond;
    else
      num_on_tags += !board.HasFeature(p.x(), p.y());
  }
  return num_on_tags <= limit(kMaxFractionOnTags) &&
         num_beyond <= limit(kMaxFractionOutside);
}

void AddPlacementsOfRotation(int quarter_turns,
                             const std::vector<Feature>& stars,
                             const Board& board,
                             std::vector<LatticePlacement>* placements) {
  Eigen::Array2i low(1 << 20, 1 << 20), high = -low;
  LatticePlacement placement;
  placement.quarter_turns = quarter_turns;
  for (const Feature& star : stars) {
    const Eigen::Array2i p = placement.OnBoard(star.column, star.row).array();
    low = low.min(p);
    high = high.max(p);
  }
  for (int row = -low.y() - 1; row + high.y() <= board.rows; ++row) {
    for (int column = -low.x() - 1; column + high.x() <= board.columns;
         ++column) {
      placement.column = column;
      placement.row = row;
      if (FitsOnBoard(placement, stars, board))
        placements->push_back(placement);
    }
  }
}

}  // namespace

Eigen::Vector2d LatticePlacement::OnBoard(
    const Eigen::Vector2d& on_lattice) const {
  return RotateByQuarterTurns(quarter_turns, on_lattice) +
         Eigen::Vector2d(column, row);
}

Eigen::Vector2i LatticePlacement::OnBoard(int lattice_column,
                                          int lattice_row) const {
  return OnBoard(Eigen::Vector2d(lattice_column, lattice_row))
      .array()
      .round()
      .cast<int>();
}

Eigen::Vector2d LatticePlacement::OnLattice(
    const Eigen::Vector2d& on_board) const {
  return RotateByQuarterTurns(4 - quarter_turns,
                              on_board - Eigen::Vector2d(column, row));
}

std::vector<LatticePlacement> ListPlacements(const std::vector<Feature>& stars,
                                             const Board& board) {
  std::vector<LatticePlacement> placements;
  const int num_rotations = CountStarSymmetries(board.segments);
  for (int k = 0; k < num_rotations; ++k)
    AddPlacementsOfRotation(4 / num_rotations * k, stars, board, &placements);
  return placements;
}

}  // namespace raygrid
