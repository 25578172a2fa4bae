/// What distinguishes kinds of targets, one source per kind. Stages that do not
/// know a kind ask it here.
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
struct MarkerPlace {
  int id = 0;
  bool is_april_tag = false;
  std::string family;      ///< of AprilTags, or a dictionary of OpenCV
  Eigen::Vector2d corner;  ///< of the outermost cell, metres
  double side_m = 0;
  int border_cells = 0;  ///< width of the black border; 0: the family's own
};

/// Boards to make, as requested. columns and rows of the board count what the
/// kind counts.
struct BoardRequest {
  Board board;
  double length_mm = 0, marker_mm = 0;
  int num_boards = 1;
  int num_tags = 1, tag_id = 0;
  std::optional<int> tag_squares, border_cells;
  std::optional<std::string> numbered_from;
  bool has_no_squares = false;
};

/// Receives the options of a kind: of `raygrid pattern KIND`, or the values of
/// a specification. Names are without hyphens.
class BoardOptions {
 public:
  virtual ~BoardOptions() = default;
  /// value: the default on entry.
  virtual void Number(const char* name, const char* help, int* value) = 0;
  virtual void Number(const char* name, const char* help, double* value) = 0;
  /// A number from 1 to max, without a default.
  virtual void Number(const char* name, const char* help, int max,
                      std::optional<int>* value) = 0;
  virtual void Text(const char* name, const char* help, std::string* value) = 0;
  virtual void Word(const char* name, const char* help,
                    const std::vector<std::string>& words,
                    std::optional<std::string>* value) = 0;
  virtual void Flag(const char* name, const char* help, bool* value) = 0;
  /// Required; the option is called NAME-mm.
  virtual void Length(const char* name, const char* help, double* value_mm) = 0;
};

/// By default a chessboard: a lattice of features where squares meet.
class TargetKind {
 public:
  virtual ~TargetKind() = default;

  std::string name;
  bool is_drawable = true;
  /// Points in space: no lattice, no nominal geometry, no front.
  bool is_point_set = false;
  /// Features are the corners of tags, and not evenly spaced.
  bool is_tag_grid = false;

  // ---- pattern.yaml
  /// The key of estimated points.
  const char* points_key = "points";
  /// Reads what follows the id and the kind.
  virtual void Read(const std::string& position, const YAML::Node& node,
                    Board* board) const;
  /// The board as an item of the list.
  virtual std::string Format(const Board& board) const;

  // ---- Geometry, in metres: x along the columns, y down the rows
  virtual double GetPosition(const Board& board, int index) const;
  /// See Board::NumRotations().
  virtual int NumRotations(const Board&) const { return 1; }

  // ---- Appearance: ink, on which white markers are placed
  virtual Area Extent(const Board& board) const;
  /// x, y: in squares.
  virtual bool IsBlack(const Board& board, double x, double y) const;
  virtual std::vector<Polygon> Ink(const Board& board) const;
  virtual std::vector<MarkerPlace> Markers(const Board&) const { return {}; }
  /// The distance from the edges of features to the nearest cell of a marker,
  /// in squares.
  virtual double MarkerDistance(const Board&) const {
    return std::numeric_limits<double>::infinity();
  }

  // ---- Texts
  /// The target on its printed page.
  virtual std::string Describe(const Board& board) const;
  /// The layout that detected features would confirm.
  virtual std::string DescribeLayout(const Board& board) const;
  /// What is searched for in images.
  virtual std::string DescribeSought(const Board& board) const;
  const char* feature = "inner corner";    ///< where lengths are measured
  const char* markers = "the dictionary";  ///< where that is wrong
  const char* more_markers = "use ";       ///< where there are too few

  // ---- Requests: the sections Target of `raygrid pattern KIND --help`
  std::string summary, example;  ///< example: of the options
  const char* counted = "inner corners";
  const char* length_help = "side length of a square";
  int max_count = 0;  ///< of columns and rows; 0: as of all boards
  /// The first column of specifications in `raygrid pattern --help`, and the
  /// lines of the second one.
  const char* specification = "";
  std::vector<const char*> specification_help;
  virtual void AddOptions(BoardOptions*, BoardRequest*) const {}
  /// The first of the boards; others differ in their first marker.
  virtual Board MakeBoard(const BoardRequest& request) const;
  /// All boards, for kinds that number their tags otherwise.
  virtual std::vector<Board> MakeBoards(const BoardRequest&) const {
    return {};
  }

  /// --columns or --tag-columns, ...
  std::string OptionName(const std::string& word) const {
    return (is_tag_grid ? "--tag-" : "--") + word;
  }
  std::string LengthOption() const {
    return is_tag_grid ? "--tag-mm" : "--square-mm";
  }

 protected:
  /// Keys of the kind alone, on reading and on writing.
  virtual void ReadKeys(const std::string&, const YAML::Node&, Board*) const {}
  virtual std::string FormatKeys(const Board&) const { return ""; }
};

/// All kinds, in the order of lists.
const std::vector<std::unique_ptr<const TargetKind>>& TargetKinds();

/// The kind of a name; for other names one that cannot be drawn.
const TargetKind& KindOf(const std::string& name);
inline const TargetKind& KindOf(const Board& board) {
  return KindOf(board.kind);
}

/// "a, b or c": the kinds that can be drawn.
std::string DrawableKinds();

/// ", first_marker: N", if that is not 0.
std::string FirstMarkerKey(const Board& board);
/// " from N", likewise.
std::string FromMarker(const Board& board);

Polygon RectanglePolygon(double x0, double y0, double x1, double y1);

#define RAYGRID_TARGET_KIND(Name) \
  std::unique_ptr<TargetKind> Make##Name##Kind();
#include "dataset/kinds/kind_list.inc"
#undef RAYGRID_TARGET_KIND

}  // namespace raygrid

#endif  // RAYGRID_DATASET_KINDS_TARGET_KIND_H
