#ifndef RAYGRID_ADJUSTMENT_DEFORMATION_MODES_H
#define RAYGRID_ADJUSTMENT_DEFORMATION_MODES_H

#include <Eigen/Core>
#include <vector>

namespace raygrid {

/// Order of the polynomials of out-of-plane deformation modes. Modes of one
/// order share a prior variance.
enum class DeformationOrder { kSecond, kThird, kFourth };
constexpr int kNumDeformationOrders = 3;

/// Whether deformation is per view (one vector per pose) or static (per board).
enum class DeformationScope { kPose, kBoard };

/// Deformation modes M of the boards. In a view, the target points are p + M f,
/// with one coefficient f per mode.
struct DeformationModes {
  static constexpr int kMaxCount = 12;  ///< 3 + 4 + 5 modes of orders 2 to 4
  using Displacement =
      Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxCount>;
  using Coefficients =
      Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxCount, 1>;

  /// M of each point, in the board frame. Modes are normalized to an RMS
  /// displacement of 1; zero where a board does not have a mode.
  std::vector<Displacement> by_point;
  std::vector<DeformationOrder> orders;  ///< order of each mode
  std::vector<int> boards;               ///< index of each point's board

  double board_radius_m = 0;  ///< RMS over all boards

  int count() const { return static_cast<int>(orders.size()); }
  int num_boards() const;
  /// Returns the largest plausible standard deviation of a coefficient (m);
  /// larger values indicate another cause.
  double MaxStdDevM() const;
  /// Removes the modes of an order and their coefficients.
  void Remove(DeformationOrder order, std::vector<Coefficients>* coefficients);
};

/// The range of one board's points among all points.
struct BoardPoints {
  int first = 0;
  std::vector<Eigen::Vector3d> nominal;
};

/// Makes the modes of nominally planar boards, orthogonal to each other and to
/// rigid motions. Non-planar boards have none; small boards only as many as
/// their points can distinguish.
DeformationModes MakeDeformationModes(const std::vector<BoardPoints>& boards,
                                      int num_points);

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_DEFORMATION_MODES_H
