#include "dataset/kinds/star.h"

#include <algorithm>
#include <cmath>

#include "dataset/kinds/board_keys.h"
#include "dataset/kinds/target_kind.h"

namespace raygrid {
namespace {

constexpr double kTagSideMm = 40;
constexpr int kMaxSegments = 32;  // more are not resolved in most images
constexpr int kMaxTagsOnABoard = 100;

// Returns the number of tags in row k of num_rows.
int CountTagsInRow(int num_tags, int num_rows, int k) {
  return num_tags * (k + 1) / num_rows - num_tags * k / num_rows;
}

// Returns the number of rows of tags that maximizes the distance between tags.
// The printed area is one square wider and higher than the lattice.
int CountTagRows(const StarBoardOptions& options) {
  int best_rows = 1;
  double best_pitch = 0;
  for (int rows = 1; rows <= options.num_tags; ++rows) {
    const int columns = (options.num_tags + rows - 1) / rows;
    const double pitch = std::min((options.columns + 1.0) / columns,
                                  (options.rows + 1.0) / rows);
    if (pitch > best_pitch) {
      best_pitch = pitch;
      best_rows = rows;
    }
  }
  return best_rows;
}

// Returns the first lattice position of tag k of `count` tags along a side with
// num_features features.
int TagStart(int num_features, int squares, int k, int count) {
  const double center = -1 + (num_features + 1) * (k + 0.5) / count;
  return static_cast<int>(std::ceil(center - squares / 2.0 - 0.5));
}

std::vector<BoardTag> LayOutTags(const StarBoardOptions& options, int squares) {
  std::vector<BoardTag> tags;
  const int num_rows = CountTagRows(options);
  for (int row = 0; row < num_rows; ++row) {
    const int count = CountTagsInRow(options.num_tags, num_rows, row);
    for (int k = 0; k < count; ++k) {
      BoardTag tag;
      tag.squares = squares;
      tag.column = TagStart(options.columns, squares, k, count);
      tag.row = TagStart(options.rows, squares, row, num_rows);
      tags.push_back(tag);
    }
  }
  return tags;
}

// Whether all tags are surrounded by features and separate from each other.
bool AreApart(const StarBoardOptions& options,
              const std::vector<BoardTag>& tags) {
  for (size_t i = 0; i < tags.size(); ++i) {
    const BoardTag& a = tags[i];
    if (a.column < 1 || a.row < 1 ||
        a.column + a.squares > options.columns - 2 ||
        a.row + a.squares > options.rows - 2)
      return false;
    for (size_t j = 0; j < i; ++j)
      if (std::max(std::abs(a.column - tags[j].column),
                   std::abs(a.row - tags[j].row)) <= a.squares)
        return false;
  }
  return true;
}

void RequireValidLayout(const StarBoardOptions& options) {
  const auto require = [](bool is_met, const char* message) {
    if (!is_met) throw Error(ExitCode::kUsage, message);
  };
  require(options.segments >= 4 && options.segments <= kMaxSegments &&
              options.segments % 2 == 0,
          "--segments must be an even number from 4 to 32");
  require(std::min(options.columns, options.rows) >= 2 &&
              std::max(options.columns, options.rows) <= 1000 &&
              options.square_mm > 0 && std::isfinite(options.square_mm),
          "columns and rows must be 2 to 1000, and squares larger than 0 mm");
  require(options.num_boards >= 1 && options.num_boards <= 100,
          "--boards must be 1 to 100");
  require(options.num_tags >= 1 && options.num_tags <= kMaxTagsOnABoard,
          "--tags must be 1 to 100");
  require(options.tag_squares >= 0 && options.tag_squares <= 1000,
          "--tag-squares must be 0 to 1000");
  require(options.tag_id >= 0, "--tag-id must not be negative");
}

BoardTag ParseTag(const std::string& position, const YAML::Node& node) {
  BoardTag tag;
  tag.family = OptionalValue<std::string>(position, node, "family", tag.family);
  tag.id = Value<int>(position, node, "id");
  tag.column = Value<int>(position, node, "column");
  tag.row = Value<int>(position, node, "row");
  tag.squares = Value<int>(position, node, "squares");
  if (tag.family != "tag36h11")
    throw InputError(fmt::format(
        "{}: unsupported tag family '{}'; use tag36h11", position, tag.family));
  return tag;
}

// Returns the part of a convex polygon where sign * (p[axis] - bound) <= 0.
Polygon ClippedAt(const Polygon& polygon, int axis, double sign, double bound) {
  Polygon clipped;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    const double da = sign * (a[axis] - bound), db = sign * (b[axis] - bound);
    if (da <= 0) clipped.push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0))
      clipped.push_back(a + (b - a) * (da / (da - db)));
  }
  return clipped;
}

Polygon ClipOutliers(Polygon polygon, const Area& area) {
  polygon = ClippedAt(polygon, 0, -1, area.x0);
  polygon = ClippedAt(polygon, 0, 1, area.x1);
  polygon = ClippedAt(polygon, 1, -1, area.y0);
  return ClippedAt(polygon, 1, 1, area.y1);
}

// Returns the point where a ray from the centre leaves the square of half width
// 1. angle: counter-clockwise from up.
Eigen::Vector2d PointOnSquare(double angle) {
  const Eigen::Vector2d direction(-std::sin(angle), -std::cos(angle));
  return direction / direction.cwiseAbs().maxCoeff();
}

// Returns segment k of a star in a square of half width 1.
Polygon Segment(int segments, int k) {
  const double begin = 2 * M_PI * k / segments;
  const double end = 2 * M_PI * (k + 1) / segments;
  Polygon polygon = {{0, 0}, PointOnSquare(begin)};
  for (double corner = M_PI / 4; corner < 2 * M_PI; corner += M_PI / 2)
    if (corner > begin + 1e-9 && corner < end - 1e-9)
      polygon.push_back(PointOnSquare(corner));
  polygon.push_back(PointOnSquare(end));
  return polygon;
}

std::string TagIds(const Board& board) {
  std::string ids;
  for (const BoardTag& tag : board.tags)
    ids += fmt::format("{}{}", ids.empty() ? "" : ", ", tag.id);
  return ids;
}

class StarKind : public TargetKind {
 public:
  StarKind() {
    name = "star";
    feature_name = "star's centre";
    summary = "Star pattern with an AprilTag, made for generic camera models.";
    example = "--columns 16 --rows 23 --square-mm 11";
    counted_name = "features";
    specification = "star:16x23:11mm";
    specification_help = {"features, spacing; optional: segments,",
                          "tags, tag-id, tag-squares, boards"};
  }

  bool IsBlack(const Board& board, double x, double y) const override {
    return IsBlackInStar(board.segments, x - std::round(x), y - std::round(y));
  }

  std::vector<Polygon> Ink(const Board& board) const override {
    std::vector<Polygon> ink;
    const double s = board.square_m;
    const Area extent = Extent(board);
    for (int row = -1; row <= board.rows; ++row) {
      for (int column = -1; column <= board.columns; ++column) {
        for (int k = 0; k < board.segments; k += 2) {
          Polygon polygon = Segment(board.segments, k);
          for (Eigen::Vector2d& p : polygon)
            p = {(column + p.x() / 2) * s, (row + p.y() / 2) * s};
          polygon = ClipOutliers(std::move(polygon), extent);
          if (polygon.size() > 2) ink.push_back(std::move(polygon));
        }
      }
    }
    return ink;
  }

  std::vector<MarkerPosition> Markers(const Board& board) const override {
    std::vector<MarkerPosition> markers;
    for (const BoardTag& tag : board.tags)
      markers.push_back({tag.id, true, tag.family,
                         Eigen::Vector2d(tag.column, tag.row) * board.square_m,
                         tag.squares * board.square_m});
    return markers;
  }

  std::string Describe(const Board& board) const override {
    return fmt::format(
        "star board {}, {} x {} features, squares {:g} mm, {} segments, {} {}",
        board.id, board.columns, board.rows, board.square_m * 1000,
        board.segments, board.tags.front().family, TagIds(board));
  }

  std::string DescribeSought(const Board& board) const override {
    return fmt::format("a star board of {} x {} stars with tag {} of {}",
                       board.columns, board.rows, board.tags.front().id,
                       board.tags.front().family);
  }

  void AddOptions(BoardOptions* options, BoardRequest* request) const override {
    request->board.segments = StarBoardOptions().segments;
    options->Number("segments",
                    "number of segments of a star, even, 4 to 32; use fewer "
                    "for blurred or small images",
                    &request->board.segments);
    options->Number("tag-id", "ID of the first tag (tag36h11)",
                    &request->tag_id);
    options->Number("tags",
                    "tags per board; more tags allow views of smaller parts",
                    &request->num_tags);
    options->Number("tag-squares",
                    "side length of a tag in squares (default: about 40 mm)", 0,
                    &request->tag_squares);
    options->Number("boards", "number of boards with distinct markers",
                    &request->num_boards);
  }

  std::vector<Board> MakeBoards(const BoardRequest& request) const override {
    return StarBoards({request.board.columns, request.board.rows,
                       request.length_mm, request.board.segments,
                       request.num_boards, request.num_tags, request.tag_id,
                       request.tag_squares.value_or(0)});
  }

 protected:
  void ReadKeys(const std::string& position, const YAML::Node& node,
                Board* board) const override {
    board->segments = OptionalValue<int>(position, node, "segments", 16);
    if (board->segments < 4 || board->segments > 64 || board->segments % 2 != 0)
      throw InputError(fmt::format(
          "{}: 'segments' must be an even number from 4 to 64", position));
    if (!node["tags"].IsSequence() || node["tags"].size() == 0)
      throw InputError(fmt::format(
          "{}: 'tags' must list at least one tag for a star board", position));
    for (const YAML::Node& item : node["tags"]) {
      const BoardTag tag = ParseTag(position, item);
      if (tag.squares < 1 || tag.column < -1 || tag.row < -1 ||
          tag.column + tag.squares > board->columns ||
          tag.row + tag.squares > board->rows)
        throw InputError(
            fmt::format("{}: tag {} is outside the board", position, tag.id));
      board->tags.push_back(tag);
    }
  }

  std::string FormatKeys(const Board& board) const override {
    std::string tags;
    for (const BoardTag& tag : board.tags)
      tags += fmt::format(
          "{}{{family: {}, id: {}, column: {}, row: {}, squares: {}}}",
          tags.empty() ? "" : ", ", tag.family, tag.id, tag.column, tag.row,
          tag.squares);
    return fmt::format(", segments: {}, tags: [{}]", board.segments, tags);
  }
};

}  // namespace

bool IsBlackInStar(int segments, double right, double down) {
  const double turns = std::atan2(-right, -down) / (2 * M_PI);
  const int k = static_cast<int>(std::floor(turns * segments));
  return k % 2 == 0;  // segments is even, so negative k need not be wrapped
}

int DefaultTagSquares(int columns, int rows, double square_mm) {
  const int half_board = std::max(2, (std::min(columns, rows) - 1) / 2);
  const double wanted = std::ceil(kTagSideMm / square_mm);
  return wanted > half_board ? half_board
                             : std::max(2, static_cast<int>(wanted));
}

std::vector<Board> StarBoards(const StarBoardOptions& options) {
  RequireValidLayout(options);
  Board board;
  board.kind = "star";
  board.columns = options.columns;
  board.rows = options.rows;
  board.square_m = options.square_mm / 1000;
  board.segments = options.segments;
  const int squares =
      options.tag_squares > 0
          ? options.tag_squares
          : DefaultTagSquares(options.columns, options.rows, options.square_mm);
  board.tags = LayOutTags(options, squares);
  if (!AreApart(options, board.tags))
    throw Error(
        ExitCode::kUsage,
        fmt::format("cannot place {} {} with a width of {} squares among {} x "
                    "{} features; use fewer --tags, a smaller --tag-squares, "
                    "or more --columns and --rows",
                    options.num_tags, options.num_tags == 1 ? "tag" : "tags",
                    squares, options.columns, options.rows));
  std::vector<Board> boards;
  int tag_id = options.tag_id;
  for (board.id = 0; board.id < options.num_boards; ++board.id) {
    for (BoardTag& tag : board.tags) tag.id = tag_id++;
    boards.push_back(board);
  }
  return boards;
}

std::unique_ptr<TargetKind> MakeStarKind() {
  return std::make_unique<StarKind>();
}

}  // namespace raygrid
