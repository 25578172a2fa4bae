#ifndef RAYGRID_DATASET_PATTERN_H
#define RAYGRID_DATASET_PATTERN_H

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "camera/pose.h"

namespace raygrid {

/// Feature points of all boards of a pattern.
constexpr size_t kMaxPatternPoints = 100000;

/// An AprilTag on a star board. Its area, white margin included, is squares
/// wide; its top-left corner lies at feature position (column, row).
struct BoardTag {
  std::string family = "tag36h11";
  int id = 0;
  int column = 0, row = 0;
  int squares = 0;
};

/// A calibration target: columns x rows feature points.
struct Board {
  int id = 0;
  std::string kind;  ///< see dataset/kinds
  int columns = 0, rows = 0;
  double square_m = 0;  ///< between features; AprilGrid: a tag's black square

  int segments = 0;            ///< star: black and white ones, counted together
  std::vector<BoardTag> tags;  ///< star
  double marker_m = 0;         ///< ChArUco: side of a marker's black square
  std::string dictionary;      ///< ChArUco: as OpenCV names it
  bool is_legacy = false;  ///< ChArUco: markers as OpenCV put them before 4.6
  /// AprilGrid: as AprilTag names it, or an ArUco dictionary as OpenCV does
  std::string tag_family;
  double spacing_ratio = 0;  ///< AprilGrid: gap between tags / square_m
  int first_marker = 0;      ///< ChArUco, AprilGrid: the lowest marker number
  /// AprilGrid: black squares touch the tags' corners, as Kalibr draws them.
  bool has_corner_squares = true;
  int border_cells = 2;  ///< AprilGrid: width of a tag's black border
  /// AprilGrid: tags are numbered row by row from the top left, as OpenCV's
  /// GridBoard has them; otherwise from the bottom left, as Kalibr has them.
  bool is_numbered_from_top = false;

  /// The places of the features, row by row: nominal, or as a calibration found
  /// them.
  std::vector<Eigen::Vector3d> points;

  int num_points() const { return columns * rows; }
  /// The index of the point at a column and row within the board.
  int PointIndex(int column, int row) const { return row * columns + column; }
  /// In how many ways the board can be turned in its plane so that it looks as
  /// before: 2 for chessboards whose counts of corners are both even or both
  /// odd, 4 if these are equal and even, else 1.
  int NumRotations() const;
  /// The column and row of the feature that one becomes by a turn, from 0 to
  /// NumRotations() - 1 steps from the x axis towards the y axis.
  std::pair<int, int> Rotated(int column, int row, int turn) const;
  /// Whether the ink around features is symmetric about them, but for markers
  /// and the board's edge: not that of corners on white paper.
  bool HasSymmetricFeatures() const { return has_corner_squares; }
  /// Whether boards are identified by tags or markers.
  bool HasMarkers() const {
    return !tags.empty() || !dictionary.empty() || !tag_family.empty();
  }
  /// Points in space: no lattice, no nominal geometry, no front.
  bool IsPointSet() const;
  /// Features are the corners of tags, and not evenly spaced.
  bool IsTagGrid() const;
  /// False for positions on or inside a tag of a star board.
  bool HasFeature(int column, int row) const;
  /// The nominal points, in the plane z = 0: (column, row) square_m, but for
  /// AprilGrids, whose features are the corners of the tags' black squares.
  std::vector<Eigen::Vector3d> NominalPoints() const;
};

/// Boards that are fixed to each other, as a calibration found them.
struct RigidTarget {
  std::vector<int> boards;             ///< ids
  std::vector<Pose> first_from_board;  ///< of each
};

/// pattern.yaml.
struct Pattern {
  std::vector<Board> boards;
  /// The file's text as read, so that keys that are not used here are kept on
  /// writing.
  std::string yaml;
  std::vector<RigidTarget> rigid_targets =
      {};  ///< other boards move by themselves

  /// nullptr if there is no such board.
  const Board* FindBoard(int id) const;
};

/// Throws InputError for more than kMaxPatternPoints.
void RequireFewPoints(const std::string& place, size_t count);

/// Throws InputError; name is used in errors.
Pattern ParsePattern(const std::string& name, const std::string& yaml);
Pattern ReadPattern(const std::string& path);

/// The text of pattern.yaml with the boards' points as they are now.
std::string FormatPattern(const Pattern& pattern);

/// Sets whether an AprilGrid has corner squares, and the border and numbering
/// that usually go with it: Kalibr's with squares, OpenCV's without.
void SetCornerSquares(bool has_corner_squares, Board* board);

/// A chessboard with columns x rows inner corners.
Pattern ChessboardPattern(int columns, int rows, double square_m);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_PATTERN_H
