#include "dataset/kinds/target_kind.h"

namespace raygrid {
namespace {

class ChessboardKind : public TargetKind {
 public:
  ChessboardKind() {
    name = "chessboard";
    summary = "Chessboard.";
    example = "--columns 9 --rows 6 --square-mm 25";
    specification = "chessboard:9x6:25mm";
    specification_help = {"inner corners, side length of a square"};
  }

  int NumRotations(const Board& board) const override {
    if (board.columns % 2 != board.rows % 2) return 1;
    return board.columns == board.rows && board.columns % 2 == 0 ? 4 : 2;
  }
};

}  // namespace

std::unique_ptr<TargetKind> MakeChessboardKind() {
  return std::make_unique<ChessboardKind>();
}

}  // namespace raygrid
