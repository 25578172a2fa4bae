#ifndef RAYGRID_FEATURES_BOARD_VIEW_FEATURE_LATTICE_H
#define RAYGRID_FEATURES_BOARD_VIEW_FEATURE_LATTICE_H

#include <Eigen/Core>
#include <vector>

#include "dataset/dataset.h"
#include "features/board_view/local_mapping.h"

namespace raygrid {

/// The features of one board found so far, by column and row.
class FeatureLattice {
 public:
  explicit FeatureLattice(const Board& board);

  bool IsOnBoard(int column, int row) const {
    return column >= 0 && row >= 0 && column < board_->columns &&
           row < board_->rows;
  }
  bool Has(int column, int row) const {
    return IsOnBoard(column, row) && found_[board_->PointIndex(column, row)];
  }
  const Eigen::Vector2d& at(int column, int row) const {
    return pixels_[board_->PointIndex(column, row)];
  }
  void Set(int column, int row, const Eigen::Vector2d& pixel);
  void Remove(int column, int row);
  int num_found() const { return num_found_; }

  /// Returns the features at most `reach` columns and rows away, with offsets
  /// from (column, row) in squares; weights decrease with the distance.
  /// with_itself: includes (column, row).
  std::vector<Correspondence> Around(int column, int row, int reach,
                                     bool with_itself) const;

  /// Returns how many of the 24 surrounding features are found.
  int CountNeighbours(int column, int row) const;

  /// Returns the features ordered by row, then column.
  std::vector<Feature> Features() const;

 private:
  const Board* board_;
  std::vector<Eigen::Vector2d>
      target_positions_;  // target positions in squares
  std::vector<Eigen::Vector2d> pixels_;
  std::vector<char> found_;
  int num_found_ = 0;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_FEATURE_LATTICE_H
