#ifndef RAYGRID_DATASET_PATTERN_H
#define RAYGRID_DATASET_PATTERN_H

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "camera/pose.h"

namespace raygrid {

/// Maximum number of feature points over all boards of a pattern.
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
  double square_m = 0;  ///< feature distance; AprilGrid: a tag's black square

  int segments = 0;            ///< star: number of black and white segments
  std::vector<BoardTag> tags;  ///< star
  double marker_m = 0;         ///< ChArUco: side of a marker's black square
  std::string dictionary;      ///< ChArUco: OpenCV's name
  bool is_legacy = false;      ///< ChArUco: markers as before OpenCV 4.6
  /// AprilGrid: AprilTag's name, or an ArUco dictionary as OpenCV names it.
  std::string tag_family;
  double spacing_ratio = 0;  ///< AprilGrid: gap between tags / square_m
  int first_marker = 0;      ///< ChArUco, AprilGrid: lowest marker ID
  /// AprilGrid: black squares touch the tags' corners, as in Kalibr.
  bool has_corner_squares = true;
  int border_cells = 2;  ///< AprilGrid: width of a tag's black border
  /// AprilGrid: tags are numbered row by row from the top left, as in OpenCV's
  /// GridBoard; otherwise from the bottom left, as in Kalibr.
  bool is_numbered_from_top = false;

  /// Positions of the features, row by row: nominal, or estimated by a
  /// calibration.
  std::vector<Eigen::Vector3d> points;

  int num_points() const { return columns * rows; }
  /// Returns the index of the point at a column and row.
  int PointIndex(int column, int row) const { return row * columns + column; }
  /// Returns the order of the board's rotational symmetry: 2 for chessboards
  /// whose numbers of corners are both even or both odd, 4 if they are equal
  /// and even, else 1.
  int NumRotations() const;
  /// Returns the column and row to which a rotation moves a feature: turn is 0
  /// to NumRotations() - 1 steps from the x axis towards the y axis.
  std::pair<int, int> Rotated(int column, int row, int turn) const;
  /// Returns whether the pattern around each feature is point-symmetric, apart
  /// from markers and the board's edge: false for tag corners on white paper.
  bool HasSymmetricFeatures() const { return has_corner_squares; }
  /// Returns whether boards are identified by tags or markers.
  bool HasMarkers() const {
    return !tags.empty() || !dictionary.empty() || !tag_family.empty();
  }
  /// Returns whether the target has no lattice, nominal geometry or front side.
  bool IsPointSet() const;
  /// Returns whether features are the corners of tags, not evenly spaced.
  bool IsTagGrid() const;
  /// Returns false for positions on or inside a tag of a star board.
  bool HasFeature(int column, int row) const;
  /// Returns the nominal points in the plane z = 0: (column, row) square_m, or
  /// for AprilGrids the corners of the tags' black squares.
  std::vector<Eigen::Vector3d> NominalPoints() const;
};

/// A rigid multi-board target, as estimated by a calibration.
struct RigidTarget {
  std::vector<int> boards;             ///< board ids
  std::vector<Pose> first_from_board;  ///< poses by board
};

/// The contents of pattern.yaml.
struct Pattern {
  std::vector<Board> boards;
  /// Text of the file as read, so that keys that are not used here are
  /// preserved when writing.
  std::string yaml;
  std::vector<RigidTarget> rigid_targets =
      {};  ///< other boards are independent

  /// Returns nullptr if there is no such board.
  const Board* FindBoard(int id) const;
};

/// Throws InputError for more than kMaxPatternPoints.
void CheckPointLimit(const std::string& position, size_t count);

/// Parses pattern.yaml. Throws InputError; name is used in errors.
Pattern ParsePattern(const std::string& name, const std::string& yaml);
Pattern ReadPattern(const std::string& path);

/// Formats pattern.yaml with the current points of the boards.
std::string FormatPattern(const Pattern& pattern);

/// Sets whether an AprilGrid has corner squares, and the associated border and
/// numbering: Kalibr's with squares, OpenCV's without.
void SetCornerSquares(bool has_corner_squares, Board* board);

/// Makes a chessboard with columns x rows inner corners.
Pattern ChessboardPattern(int columns, int rows, double square_m);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_PATTERN_H
