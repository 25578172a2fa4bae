/// Interface of the kinds of targets, one source file per kind. Other modules
/// access properties of a kind through it.
#ifndef RAYGRID_DATASET_KINDS_TARGET_KIND_H
#define RAYGRID_DATASET_KINDS_TARGET_KIND_H

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "camera/area.h"
#include "dataset/pattern.h"

namespace YAML {
class Node;
}

namespace raygrid {

using Polygon = std::vector<Eigen::Vector2d>;

/// A marker on a board.
struct MarkerPosition {
  int id = 0;
  bool is_april_tag = false;
  std::string family;      ///< AprilTag family or OpenCV dictionary
  Eigen::Vector2d corner;  ///< corner of the outermost cell, metres
  double side_m = 0;
  int border_cells = 0;  ///< width of the black border; 0: family's default
};

/// Requested boards. `board.columns` and `board.rows` are numbers of the
/// objects that TargetKind::counted_name names.
struct BoardRequest {
  Board board;
  double length_mm = 0, marker_mm = 0;
  int num_boards = 1;
  int num_tags = 1, tag_id = 0;
  std::optional<int> tag_squares, border_cells;
  std::optional<std::string> numbering_origin;
  bool has_no_squares = false;
};

/// Receives the options of a kind, for `raygrid pattern KIND` and for
/// specifications. Names have no leading hyphens.
class BoardOptions {
 public:
  virtual ~BoardOptions() = default;
  /// value: default on entry
  virtual void Number(const char* name, const char* help, int* value) = 0;
  virtual void Number(const char* name, const char* help, double* value) = 0;
  /// A number from 1 to max without a default.
  virtual void Number(const char* name, const char* help, int max,
                      std::optional<int>* value) = 0;
  virtual void Text(const char* name, const char* help, std::string* value) = 0;
  virtual void Word(const char* name, const char* help,
                    const std::vector<std::string>& words,
                    std::optional<std::string>* value) = 0;
  virtual void Flag(const char* name, const char* help, bool* value) = 0;
  /// A required length; the option is called NAME-mm.
  virtual void Length(const char* name, const char* help, double* value_mm) = 0;
};

/// Kind of a target. By default a chessboard, with features where squares meet.
class TargetKind {
 public:
  virtual ~TargetKind() = default;

  std::string name;
  bool is_drawable = true;
  /// 3-D points without a lattice, nominal geometry or front side.
  bool is_point_set = false;
  /// Features are the corners of tags, which are not evenly spaced.
  bool is_tag_grid = false;

  // ---- pattern.yaml
  /// Key of the estimated points.
  const char* points_key = "points";
  /// Reads the keys other than id and kind.
  virtual void Read(const std::string& position, const YAML::Node& node,
                    Board* board) const;
  /// Formats the board as an item of the list of boards.
  virtual std::string Format(const Board& board) const;

  // ---- Geometry, in metres: x along the columns, y down the rows
  virtual double GetPosition(const Board& board, int index) const;
  /// See Board::NumRotations().
  virtual int NumRotations(const Board&) const { return 1; }

  // ---- Appearance: ink, on which white markers are placed
  virtual Area Extent(const Board& board) const;
  /// x, y: board coordinates in squares.
  virtual bool IsBlack(const Board& board, double x, double y) const;
  virtual std::vector<Polygon> Ink(const Board& board) const;
  virtual std::vector<MarkerPosition> Markers(const Board&) const { return {}; }
  /// Returns the distance from the edges of features to the nearest marker
  /// cell, in squares.
  virtual double MarkerDistance(const Board&) const {
    return std::numeric_limits<double>::infinity();
  }

  // ---- Descriptions
  /// Returns the description that is printed on the target.
  virtual std::string Describe(const Board& board) const;
  /// Returns the layout as far as detected features verify it.
  virtual std::string DescribeLayout(const Board& board) const;
  /// Returns what the detector searches for in images.
  virtual std::string DescribeSought(const Board& board) const;
  const char* feature_name = "inner corner";  ///< for texts about distances
  const char* marker_set_name =
      "the dictionary";  ///< for texts about wrong markers
  const char* too_few_markers_remedy = "use ";  ///< remedy for too few markers

  // ---- Options of `raygrid pattern KIND` and texts of its help
  std::string summary, example;  ///< example: of the options
  const char* counted_name = "inner corners";
  const char* length_help = "side length of a square";
  int max_count = 0;  ///< maximum number of columns or rows; 0: default
  /// Columns of the table of specifications in `raygrid pattern --help`: an
  /// example, and the lines of its explanation.
  const char* specification = "";
  std::vector<const char*> specification_help;
  virtual void AddOptions(BoardOptions*, BoardRequest*) const {}
  /// Returns the first board; others differ only in their first marker.
  virtual Board MakeBoard(const BoardRequest& request) const;
  /// Returns all boards, for kinds with a different numbering of tags.
  virtual std::vector<Board> MakeBoards(const BoardRequest&) const {
    return {};
  }

  /// Returns --columns or --tag-columns, for example.
  std::string OptionName(const std::string& word) const {
    return (is_tag_grid ? "--tag-" : "--") + word;
  }
  std::string LengthOption() const {
    return is_tag_grid ? "--tag-mm" : "--square-mm";
  }

 protected:
  /// Reads and formats the keys that are specific to the kind.
  virtual void ReadKeys(const std::string&, const YAML::Node&, Board*) const {}
  virtual std::string FormatKeys(const Board&) const { return ""; }
};

/// Returns all kinds, in the order of kind_list.inc.
const std::vector<std::unique_ptr<const TargetKind>>& TargetKinds();

/// Returns the kind with this name, or for other names one that cannot be
/// drawn.
const TargetKind& KindOf(const std::string& name);
inline const TargetKind& KindOf(const Board& board) {
  return KindOf(board.kind);
}

/// Returns "a, b or c": the kinds that can be drawn.
std::string DrawableKinds();

/// Returns ", first_marker: N", or "" if N is 0.
std::string FirstMarkerKey(const Board& board);
/// Returns " from N", or "" if N is 0.
std::string FromMarker(const Board& board);

Polygon RectanglePolygon(double x0, double y0, double x1, double y1);

#define RAYGRID_TARGET_KIND(Name) \
  std::unique_ptr<TargetKind> Make##Name##Kind();
#include "dataset/kinds/kind_list.inc"
#undef RAYGRID_TARGET_KIND

}  // namespace raygrid

#endif  // RAYGRID_DATASET_KINDS_TARGET_KIND_H
