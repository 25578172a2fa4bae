#ifndef RAYGRID_ADJUSTMENT_NODE_FRAMES_H
#define RAYGRID_ADJUSTMENT_NODE_FRAMES_H

#include <Eigen/SparseCore>

#include "adjustment/normal_equations.h"

namespace raygrid {

/// Local axes for the points of a non-central grid: two across the observation
/// line, in the directions of its stereographic coordinates, and one along it.
/// Weakly observable fields are smooth in these axes, but not in camera axes:
/// the position along the line is not observable, and shifts across it are
/// nearly confounded with rotations. Other parameters are unchanged.
class NodeFrames {
 public:
  NodeFrames() = default;
  NodeFrames(const ParameterLayout& layout, const AdjustmentState& state);

  /// Transforms vectors from the layout's axes to local axes.
  template <typename Columns>
  Columns ToNodeFrames(const Columns& vectors) const {
    if (is_same()) return vectors;
    return axes_.transpose() * vectors;
  }
  /// Transforms vectors from local axes to the layout's axes.
  template <typename Columns>
  Columns FromNodeFrames(const Columns& in_frames) const {
    if (is_same()) return in_frames;
    return axes_ * in_frames;
  }
  /// Transforms a quadratic form from the layout's axes to local axes.
  Eigen::SparseMatrix<double> TransformNodes(
      const Eigen::SparseMatrix<double>& form) const {
    if (is_same()) return form;
    return axes_.transpose() * form * axes_;
  }

 private:
  bool is_same() const { return axes_.size() == 0; }

  Eigen::SparseMatrix<double> axes_;  // orthogonal; empty if there are none
};

}  // namespace raygrid

#endif  // RAYGRID_ADJUSTMENT_NODE_FRAMES_H
