#include <algorithm>
#include <cmath>

#include "dataset/kinds/board_keys.h"
#include "dataset/kinds/target_kind.h"

namespace raygrid {
namespace {

void RequireTagFamily(const std::string& position, const Board& board) {
  const std::string& family = board.tag_family;
  if (family == "tag36h11" || family == "tag25h9" || family == "tag16h5")
    return;
  if (family.compare(0, 5, "DICT_") != 0)
    throw InputError(
        fmt::format("{}: unsupported tag family '{}'; use tag36h11, tag25h9, "
                    "tag16h5 or a dictionary such as DICT_4X4_50",
                    position, family));
  if (board.has_corner_squares)
    throw InputError(fmt::format(
        "{}: tag family '{}': dictionary markers are supported without corner "
        "squares only; set 'corner_squares: false' if there are none",
        position, family));
}

class AprilGridKind : public TargetKind {
 public:
  AprilGridKind() {
    name = "aprilgrid";
    is_tag_grid = true;
    feature_name = "tag's edge";
    marker_set_name = "the tag family";
    summary = "AprilGrid in Kalibr's layout, or a grid of separate tags.";
    example = "--tag-columns 6 --tag-rows 6 --tag-mm 24";
    counted_name = "tags";
    length_help = "side length of the black square of a tag";
    max_count = 500;
    specification = "aprilgrid:6x6:24mm";
    specification_help = {"tags, side length of a tag; optional:",
                          "family, spacing-ratio, first-marker,",
                          "boards, no-squares, border-cells,", "numbered-from"};
  }

  double GetPosition(const Board& board, int index) const override {
    return board.square_m * (index / 2 * (1 + board.spacing_ratio) + index % 2);
  }

  Area Extent(const Board& board) const override {
    const double gap = board.square_m * board.spacing_ratio;
    const double pitch = board.square_m + gap;
    const Area extent = {-gap, -gap, board.columns / 2 * pitch,
                         board.rows / 2 * pitch};
    if (board.has_corner_squares) return extent;
    return {0, 0, extent.x1 - gap, extent.y1 - gap};
  }

  // Corner squares are where the gaps between tags intersect.
  bool IsBlack(const Board& board, double x, double y) const override {
    const double pitch = 1 + board.spacing_ratio;
    return board.has_corner_squares && x - std::floor(x / pitch) * pitch >= 1 &&
           y - std::floor(y / pitch) * pitch >= 1;
  }

  std::vector<Polygon> Ink(const Board& board) const override {
    std::vector<Polygon> squares;
    if (!board.has_corner_squares) return squares;
    const double gap = board.square_m * board.spacing_ratio;
    const double pitch = board.square_m + gap;
    for (int row = 0; row <= board.rows / 2; ++row)
      for (int column = 0; column <= board.columns / 2; ++column)
        squares.push_back(RectanglePolygon(column * pitch - gap,
                                           row * pitch - gap, column * pitch,
                                           row * pitch));
    return squares;
  }

  std::vector<MarkerPosition> Markers(const Board& board) const override {
    std::vector<MarkerPosition> tags;
    const int columns = board.columns / 2, rows = board.rows / 2;
    const double pitch_m = board.square_m * (1 + board.spacing_ratio);
    for (int row = 0; row < rows; ++row) {
      const int counted_row = board.is_numbered_from_top ? row : rows - 1 - row;
      for (int column = 0; column < columns; ++column)
        tags.push_back({board.first_marker + counted_row * columns + column,
                        board.tag_family.compare(0, 3, "tag") == 0,
                        board.tag_family,
                        Eigen::Vector2d(column, row) * pitch_m, board.square_m,
                        board.border_cells});
    }
    return tags;
  }

  double MarkerDistance(const Board& board) const override {
    constexpr double kBorderCell = 0.1;
    return std::min(kBorderCell * board.border_cells, board.spacing_ratio);
  }

  std::string Describe(const Board& board) const override {
    return fmt::format(
        "AprilGrid{}, {} x {} tags of {:g} mm, spacing {:g}, {}{}",
        board.has_corner_squares ? "" : " without corner squares",
        board.columns / 2, board.rows / 2, board.square_m * 1000,
        board.spacing_ratio, board.tag_family, FromMarker(board));
  }

  std::string DescribeLayout(const Board& board) const override {
    return fmt::format(
        "an AprilGrid of {} x {} tags of {}{}", board.columns / 2,
        board.rows / 2, board.tag_family,
        board.has_corner_squares ? "" : " without corner squares");
  }

  std::string DescribeSought(const Board& board) const override {
    return fmt::format(
        "{}, with a border of {}{}", DescribeLayout(board),
        board.border_cells == 2 ? "two cells" : "one cell",
        board.has_corner_squares ? " and black squares at their corners" : "");
  }

  void AddOptions(BoardOptions* options, BoardRequest* request) const override {
    Board& board = request->board;
    board.tag_family = "tag36h11";
    board.spacing_ratio = 0.3;
    options->Number("spacing-ratio",
                    "gap between tags divided by their side length",
                    &board.spacing_ratio);
    options->Text("family",
                  "tag36h11, tag25h9 or tag16h5; with --no-squares also "
                  "OpenCV dictionaries such as DICT_4X4_50",
                  &board.tag_family);
    options->Flag("no-squares",
                  "no black squares between tags, as in AprilTag mosaics and "
                  "OpenCV's GridBoard",
                  &request->has_no_squares);
    options->Number("border-cells",
                    "width of the black border of a tag, 1 or 2 cells "
                    "(default: 2; 1 with --no-squares)",
                    2, &request->border_cells);
    options->Word("numbered-from",
                  "row in which the tag IDs start (default: bottom; top with "
                  "--no-squares)",
                  {"top", "bottom"}, &request->numbering_origin);
    options->Number(
        "first-marker",
        "ID of the leftmost tag in the row given by --numbered-from",
        &board.first_marker);
    options->Number("boards", "number of boards with distinct markers",
                    &request->num_boards);
  }

  Board MakeBoard(const BoardRequest& request) const override {
    Board board = TargetKind::MakeBoard(request);
    SetCornerSquares(!request.has_no_squares, &board);
    board.border_cells = request.border_cells.value_or(board.border_cells);
    if (request.numbering_origin)
      board.is_numbered_from_top = *request.numbering_origin == "top";
    board.columns *= 2;  // 2 x 2 features per tag
    board.rows *= 2;
    return board;
  }

 protected:
  void ReadKeys(const std::string& position, const YAML::Node& node,
                Board* board) const override {
    board->tag_family =
        OptionalValue<std::string>(position, node, "tag_family", "tag36h11");
    board->spacing_ratio = Value<double>(position, node, "spacing_ratio");
    board->first_marker = OptionalValue<int>(position, node, "first_marker", 0);
    SetCornerSquares(
        OptionalValue<bool>(position, node, "corner_squares", true), board);
    board->border_cells =
        OptionalValue<int>(position, node, "border_cells", board->border_cells);
    const auto numbered_from = OptionalValue<std::string>(
        position, node, "numbered_from",
        board->is_numbered_from_top ? "top" : "bottom");
    board->is_numbered_from_top = numbered_from == "top";
    RequireTagFamily(position, *board);
    if (numbered_from != "top" && numbered_from != "bottom")
      throw InputError(
          fmt::format("{}: numbered_from must be top or bottom, not '{}'",
                      position, numbered_from));
    if (board->border_cells != 1 && board->border_cells != 2)
      throw InputError(
          fmt::format("{}: 'border_cells' must be 1 or 2", position));
    if (!(board->spacing_ratio > 0 && board->spacing_ratio < 10))
      throw InputError(
          fmt::format("{}: 'spacing_ratio' must be positive", position));
    if (board->columns % 2 != 0 || board->rows % 2 != 0)
      throw InputError(
          fmt::format("{}: columns and rows of an AprilGrid must be even, with "
                      "2 x 2 features per tag",
                      position));
  }

  std::string FormatKeys(const Board& board) const override {
    std::string keys = fmt::format(", tag_family: {}, spacing_ratio: {:.9g}",
                                   board.tag_family, board.spacing_ratio);
    if (!board.has_corner_squares) keys += ", corner_squares: false";
    if (board.border_cells != (board.has_corner_squares ? 2 : 1))
      keys += fmt::format(", border_cells: {}", board.border_cells);
    if (board.is_numbered_from_top == board.has_corner_squares)
      keys += fmt::format(", numbered_from: {}",
                          board.is_numbered_from_top ? "top" : "bottom");
    return keys + FirstMarkerKey(board);
  }
};

}  // namespace

void SetCornerSquares(bool has_corner_squares, Board* board) {
  board->has_corner_squares = has_corner_squares;
  board->border_cells = has_corner_squares ? 2 : 1;
  board->is_numbered_from_top = !has_corner_squares;
}

std::unique_ptr<TargetKind> MakeAprilGridKind() {
  return std::make_unique<AprilGridKind>();
}

}  // namespace raygrid
