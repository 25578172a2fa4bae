#ifndef RAYGRID_ADJUSTMENT_NODE_FRAMES_H
#define RAYGRID_ADJUSTMENT_NODE_FRAMES_H

#include <Eigen/SparseCore>

#include "adjustment/normal_equations.h"

namespace raygrid {

/// Axes of their own for the points of a non-central grid's nodes: two across
/// the node's line, in the directions of its stereographic coordinates, and one
/// along it. What observations tell little of is smooth in these axes, but not
/// in the camera's: no observation tells how far a point is along its line, and
/// few tell a shift across it from a turn. Other parameters stay as they are.
class NodeFrames {
 public:
  NodeFrames() = default;
  NodeFrames(const ParameterLayout& layout, const AdjustmentState& state);

  /// Vectors over a layout's parameters, in these axes.
  template <typename Columns>
  Columns Into(const Columns& vectors) const {
    if (is_same()) return vectors;
    return axes_.transpose() * vectors;
  }
  /// Vectors in these axes, over the layout's parameters.
  template <typename Columns>
  Columns OutOf(const Columns& in_frames) const {
    if (is_same()) return in_frames;
    return axes_ * in_frames;
  }
  /// A quadratic form over the layout's parameters, in these axes.
  Eigen::SparseMatrix<double> FormInto(
      const Eigen::SparseMatrix<double>& form) const {
    if (is_same()) return form;
    return axes_.transpose() * form * axes_;
  }

 private:
  bool is_same() const { return axes_.size() == 0; }

  Eigen::SparseMatrix<double> axes_;  // orthogonal; none if no camera has any
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_NODE_FRAMES_H
