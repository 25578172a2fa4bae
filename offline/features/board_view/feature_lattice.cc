#include "features/board_view/feature_lattice.h"

#include <algorithm>

namespace raygrid {

FeatureLattice::FeatureLattice(const Board& board)
    : board_(&board),
      pixels_(board.num_points()),
      found_(board.num_points(), 0) {
  for (const Eigen::Vector3d& point : board.NominalPoints())
    target_positions_.push_back(point.head<2>() / board.square_m);
}

void FeatureLattice::Set(int column, int row, const Eigen::Vector2d& pixel) {
  const int index = board_->PointIndex(column, row);
  num_found_ += !found_[index];
  found_[index] = 1;
  pixels_[index] = pixel;
}

void FeatureLattice::Remove(int column, int row) {
  const int index = board_->PointIndex(column, row);
  num_found_ -= found_[index];
  found_[index] = 0;
}

std::vector<Correspondence> FeatureLattice::Around(int column, int row,
                                                   int reach,
                                                   bool with_itself) const {
  std::vector<Correspondence> around;
  const Eigen::Vector2d& center =
      target_positions_[board_->PointIndex(column, row)];
  for (int r = std::max(row - reach, 0);
       r <= std::min(row + reach, board_->rows - 1); ++r) {
    for (int c = std::max(column - reach, 0);
         c <= std::min(column + reach, board_->columns - 1); ++c) {
      const int index = board_->PointIndex(c, r);
      if (!found_[index] || (!with_itself && c == column && r == row)) continue;
      const Eigen::Vector2d offset = target_positions_[index] - center;
      around.push_back(
          {offset, pixels_[index], 1 / (1 + 0.5 * offset.squaredNorm())});
    }
  }
  return around;
}

int FeatureLattice::CountNeighbours(int column, int row) const {
  int count = 0;
  for (int r = row - 2; r <= row + 2; ++r)
    for (int c = column - 2; c <= column + 2; ++c)
      count += (c != column || r != row) && Has(c, r);
  return count;
}

std::vector<Feature> FeatureLattice::Features() const {
  std::vector<Feature> features;
  for (int row = 0; row < board_->rows; ++row)
    for (int column = 0; column < board_->columns; ++column)
      if (Has(column, row))
        features.push_back({board_->id, column, row, at(column, row)});
  return features;
}

}  // namespace raygrid
