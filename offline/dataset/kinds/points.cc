#include <algorithm>

#include "dataset/kinds/board_keys.h"
#include "dataset/kinds/target_kind.h"

namespace raygrid {
namespace {

// A target of arbitrary points, for features of external detectors.
class PointsKind : public TargetKind {
 public:
  PointsKind() {
    name = "points";
    is_drawable = false;
    is_point_set = true;
    points_key = "xyz";
  }

  void Read(const std::string& position, const YAML::Node& node,
            Board* board) const override {
    const int count = static_cast<int>(node["xyz"].size());
    board->columns =
        node["columns"] ? Value<int>(position, node, "columns") : count;
    board->rows = node["rows"] ? Value<int>(position, node, "rows") : 1;
    if (std::min(board->columns, board->rows) < 0 ||
        static_cast<int64_t>(board->columns) * board->rows != count)
      throw InputError(fmt::format("{0}: expected {2} x {3} points, found {1}",
                                   position, count, board->columns,
                                   board->rows));
  }

  std::string Format(const Board& board) const override {
    std::string yaml = fmt::format(
        "  - id: {}\n    kind: points\n    columns: {}\n    rows: {}\n    "
        "xyz:\n",
        board.id, board.columns, board.rows);
    for (const Eigen::Vector3d& point : board.points)
      yaml += fmt::format("      - [{:.9f}, {:.9f}, {:.9f}]\n", point.x(),
                          point.y(), point.z());
    return yaml;
  }
};

}  // namespace

std::unique_ptr<TargetKind> MakePointsKind() {
  return std::make_unique<PointsKind>();
}

}  // namespace raygrid
