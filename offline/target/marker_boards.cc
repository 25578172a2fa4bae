#include "target/marker_boards.h"

#include <fmt/format.h>

#include "appearance/board_appearance.h"
#include "dataset/error.h"
#include "target/board_yaml.h"

namespace raygrid {
std::vector<Board> MarkerBoards(Board board, int num_boards) {
  if (num_boards < 1 || num_boards > 100)
    throw Error(ExitCode::kUsage, "--boards must be 1 to 100");
  RequirePossibleBoards({board});
  const int num_markers =
      static_cast<int>(BoardAppearance(board).markers().size());
  std::vector<Board> boards;
  for (board.id = 0; board.id < num_boards; ++board.id) {
    boards.push_back(board);
    board.first_marker += num_markers;
  }
  try {
    RequirePossibleBoards({boards.back()});
  } catch (const Error& error) {
    throw Error(ExitCode::kUsage,
                fmt::format("{} boards with {} markers each: {}; {}fewer "
                            "--boards, or a lower --first-marker",
                            num_boards, num_markers, error.what(),
                            KindOf(board).too_few_markers_remedy));
  }
  return boards;
}

std::vector<Board> MakeBoards(const TargetKind& kind,
                              const BoardRequest& request) {
  const std::vector<Board> boards = kind.MakeBoards(request);
  return boards.empty()
             ? MarkerBoards(kind.MakeBoard(request), request.num_boards)
             : boards;
}

}  // namespace raygrid
