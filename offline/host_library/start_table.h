#ifndef RAYGRID_HOST_LIBRARY_START_TABLE_H
#define RAYGRID_HOST_LIBRARY_START_TABLE_H

#include <Eigen/Core>
#include <vector>

#include "camera/central_generic.h"

namespace raygrid {

/// Approximate pixels of directions: initial values for projections into a
/// grid, on a lattice over the directions of the area.
class StartTable {
 public:
  enum class Place {
    kFound,    ///< an initial value
    kUnknown,  ///< near directions without pixels
    kOutside   ///< farther than a cell from all directions of the area
  };

  explicit StartTable(const CentralGeneric& camera);

  /// Chart coordinates (camera/stereographic.h) to pixel.
  Place Find(const Eigen::Vector2f& chart, Eigen::Vector2f* pixel) const {
    const float x = (chart.x() - first_.x()) * cells_.x();
    const float y = (chart.y() - first_.y()) * cells_.y();
    if (!(x >= 0 && y >= 0 && x < last_column_ && y < last_row_))
      return Place::kOutside;
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    const float fx = x - static_cast<float>(column);
    const float fy = y - static_cast<float>(row);
    using Lane = Eigen::Array<float, 4, 1>;  // two adjacent nodes
    const float* upper = &pixels_[2 * (row * columns_ + column)];
    const Eigen::Map<const Lane> above(upper), below(upper + 2 * columns_);
    const Lane mixed = above + fy * (below - above);
    *pixel << mixed[0] + fx * (mixed[2] - mixed[0]),
        mixed[1] + fx * (mixed[3] - mixed[1]);
    // NaN of one node makes the sum NaN.
    return pixel->x() + pixel->y() == pixel->x() + pixel->y() ? Place::kFound
                                                              : Place::kUnknown;
  }

  /// Returns the smaller side length of a cell, in chart coordinates.
  float CellSize() const { return 1 / cells_.maxCoeff(); }

 private:
  Eigen::Vector2f first_, cells_;  ///< position of node 0; cells per unit
  int columns_ = 0;
  float last_column_ = 0, last_row_ = 0;
  std::vector<float> pixels_;  ///< x, y of each node, row by row; NaN: none
};

}  // namespace raygrid

#endif  // RAYGRID_HOST_LIBRARY_START_TABLE_H
