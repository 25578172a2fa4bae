#ifndef RAYGRID_ADJUSTMENT_BOARD_FLEX_H
#define RAYGRID_ADJUSTMENT_BOARD_FLEX_H

#include <Eigen/Core>
#include <vector>

namespace raygrid {

/// Bends out of a board's plane by polynomials of one order, which scatter
/// alike.
enum class BendOrder { kSecond, kThird, kFourth };
constexpr int kNumBendOrders = 3;

/// Which views a board is bent alike in: those of one pose, or all of the
/// board.
enum class BendScope { kPose, kBoard };

/// The ways in which boards may bend. A view's board has the points p + M f,
/// where f has a coefficient for each mode.
struct FlexModes {
  static constexpr int kMaxCount = 12;  ///< 3 + 4 + 5 bends of orders 2 to 4
  using Displacement =
      Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxCount>;
  using Coefficients =
      Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxCount, 1>;

  /// M of each point, in the pattern's frame. A mode moves a board's points by
  /// a root mean square of 1; zero where a board has no such mode.
  std::vector<Displacement> by_point;
  std::vector<BendOrder> orders;  ///< of each mode
  std::vector<int> boards;        ///< index of each point's board

  double board_radius_m = 0;  ///< root mean square of all boards

  int count() const { return static_cast<int>(orders.size()); }
  int num_boards() const;
  /// The largest standard deviation of a coefficient that is believed: larger
  /// ones are errors of another kind.
  double MaxDeviationM() const;
  /// Leaves out the modes of an order.
  void Remove(BendOrder order, std::vector<Coefficients>* coefficients);
};

/// The points of one board among those of all.
struct BoardPoints {
  int first = 0;
  std::vector<Eigen::Vector3d> nominal;
};

/// The modes of boards that are flat. Bends are orthogonal to each other and to
/// what is a motion of the board. Boards with depth have none, small ones only
/// as many as their points can tell apart.
FlexModes MakeFlexModes(const std::vector<BoardPoints>& boards, int num_points);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_BOARD_FLEX_H
