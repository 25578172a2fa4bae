#include "dataset/kinds/board_keys.h"
#include "dataset/kinds/target_kind.h"

namespace raygrid {
namespace {

class CharucoKind : public TargetKind {
 public:
  CharucoKind() {
    name = "charuco";
    summary = "ChArUco board in OpenCV's layout.";
    example = "--columns 8 --rows 5 --square-mm 28 --marker-mm 21";
    too_few_markers_remedy = "use a larger --dictionary, ";
    specification = "charuco:8x5:28mm:marker=21mm";
    specification_help = {"optional: dictionary, legacy,",
                          "first-marker, boards"};
  }

  // The first square's corner is one square to the left of and above feature
  // (0, 0).
  std::vector<MarkerPosition> Markers(const Board& board) const override {
    std::vector<MarkerPosition> markers;
    const double margin_m = (board.square_m - board.marker_m) / 2;
    int id = board.first_marker;
    for (int row = 0; row <= board.rows; ++row) {
      const int counted_row = board.is_legacy ? board.rows - row : row;
      for (int column = 0; column <= board.columns; ++column)
        if (counted_row % 2 != column % 2)
          markers.push_back({id++,
                             false,
                             board.dictionary,
                             {(column - 1) * board.square_m + margin_m,
                              (row - 1) * board.square_m + margin_m},
                             board.marker_m});
    }
    return markers;
  }

  double MarkerDistance(const Board& board) const override {
    return (board.square_m - board.marker_m) / 2 / board.square_m;
  }

  std::string Describe(const Board& board) const override {
    return fmt::format(
        "ChArUco board, {} x {} inner corners, squares {:g} mm, markers {:g} "
        "mm, {}{}{}",
        board.columns, board.rows, board.square_m * 1000, board.marker_m * 1000,
        board.dictionary, FromMarker(board), board.is_legacy ? ", legacy" : "");
  }

  std::string DescribeLayout(const Board& board) const override {
    return TargetKind::DescribeLayout(board) + " with markers of " +
           board.dictionary;
  }

  std::string DescribeSought(const Board& board) const override {
    return fmt::format("a ChArUco board of {}, black on white",
                       DescribeLayout(board));
  }

  void AddOptions(BoardOptions* options, BoardRequest* request) const override {
    Board& board = request->board;
    board.dictionary = "DICT_4X4_50";
    options->Length("marker", "side length of a marker", &request->marker_mm);
    options->Text("dictionary", "name of the marker dictionary in OpenCV",
                  &board.dictionary);
    options->Number("first-marker", "ID of the first marker",
                    &board.first_marker);
    options->Flag("legacy", "layout of OpenCV before 4.6 (legacy pattern)",
                  &board.is_legacy);
    options->Number("boards", "number of boards with distinct markers",
                    &request->num_boards);
  }

 protected:
  void ReadKeys(const std::string& position, const YAML::Node& node,
                Board* board) const override {
    board->marker_m = Value<double>(position, node, "marker_m");
    board->dictionary = Value<std::string>(position, node, "dictionary");
    board->is_legacy = OptionalValue<bool>(position, node, "legacy", false);
    board->first_marker = OptionalValue<int>(position, node, "first_marker", 0);
    if (!(board->marker_m > 0 && board->marker_m < board->square_m))
      throw InputError(fmt::format(
          "{}: 'marker_m' must be between 0 and square_m", position));
  }

  std::string FormatKeys(const Board& board) const override {
    return fmt::format(", marker_m: {:.9g}, dictionary: {}{}{}", board.marker_m,
                       board.dictionary,
                       board.is_legacy ? ", legacy: true" : "",
                       FirstMarkerKey(board));
  }
};

}  // namespace

std::unique_ptr<TargetKind> MakeCharucoKind() {
  return std::make_unique<CharucoKind>();
}

}  // namespace raygrid
