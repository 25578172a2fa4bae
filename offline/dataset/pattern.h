#ifndef RAYGRID_DATASET_PATTERN_H
#define RAYGRID_DATASET_PATTERN_H

#include <Eigen/Core>
#include <string>
#include <vector>

namespace raygrid {

/// A calibration target: columns x rows feature points.
struct Board {
  int id = 0;
  std::string kind;
  int columns = 0, rows = 0;
  double square_m = 0;
  /// Where the features are, row by row: nominal, or as a calibration found
  /// them.
  std::vector<Eigen::Vector3d> points;

  int num_points() const { return columns * rows; }
  /// column and row within the board.
  int PointIndex(int column, int row) const { return row * columns + column; }
  /// On the lattice: (column, row) square_m, z = 0.
  std::vector<Eigen::Vector3d> NominalPoints() const;
};

/// pattern.yaml.
struct Pattern {
  std::vector<Board> boards;
  /// As read, so that keys that are not used here are kept on writing.
  std::string yaml;

  /// nullptr if there is no such board.
  const Board* FindBoard(int id) const;
};

/// Throws InputError; name is used in errors.
Pattern ParsePattern(const std::string& name, const std::string& yaml);
Pattern ReadPattern(const std::string& path);

/// The text of pattern.yaml with the boards' points as they are now.
std::string FormatPattern(const Pattern& pattern);

/// A chessboard with columns x rows inner corners.
Pattern ChessboardPattern(int columns, int rows, double square_m);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_PATTERN_H
