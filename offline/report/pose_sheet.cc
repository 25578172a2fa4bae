#include "report/pose_sheet.h"

#include <optional>
#include <utility>

#include "report/contact_sheet.h"
#include "report/plots.h"

namespace raygrid {
namespace {

constexpr SheetColor kAxisColors[] = {
    {0.95, 0.15, 0.1}, {0.1, 0.75, 0.15}, {0.2, 0.4, 1.0}};

// A polyline in a downscaled picture, interrupted at points that are not
// visible.
class PixelCurve {
 public:
  PixelCurve(const CameraModel& camera, const Pose& camera_from_board,
             double scale)
      : camera_(camera), pose_(camera_from_board), scale_(scale) {}

  void Add(const Eigen::Vector3d& point) {
    const auto pixel = camera_.Project(pose_ * point);
    if (!pixel) {
      EndSegment();
      return;
    }
    if (is_interrupted_) segments_.emplace_back();
    is_interrupted_ = false;
    const Eigen::Vector2d half(0.5, 0.5);
    segments_.back().push_back(scale_ * (*pixel + half) - half);
  }
  void EndSegment() { is_interrupted_ = true; }

  std::vector<std::vector<Eigen::Vector2d>> TakeSegments() {
    return std::move(segments_);
  }

 private:
  const CameraModel& camera_;
  const Pose& pose_;
  double scale_;
  bool is_interrupted_ = true;
  std::vector<std::vector<Eigen::Vector2d>> segments_;
};

SheetCurves LatticeCurves(const Board& board, PixelCurve curve) {
  for (int row = 0; row < board.rows; ++row, curve.EndSegment())
    for (int column = 0; column < board.columns; ++column)
      curve.Add(board.points[board.PointIndex(column, row)]);
  for (int column = 0; column < board.columns; ++column, curve.EndSegment())
    for (int row = 0; row < board.rows; ++row)
      curve.Add(board.points[board.PointIndex(column, row)]);
  SheetCurves curves;
  curves.curves = curve.TakeSegments();
  curves.color = kAreaColor;
  curves.width = 1;
  return curves;
}

// Returns the length of drawn axes: a third of the board's longest side.
double AxisLength(const Board& board) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : board.points) box.extend(point);
  return box.sizes().maxCoeff() / 3;
}

SheetCurves AxisCurve(int axis, double length, PixelCurve curve) {
  constexpr int kSteps = 20;  // for curves due to distortion
  for (int k = 0; k <= kSteps; ++k)
    curve.Add(length * k / kSteps * Eigen::Vector3d::Unit(axis));
  SheetCurves curves;
  curves.curves = curve.TakeSegments();
  curves.color = kAxisColors[axis];
  curves.width = 3;
  return curves;
}

SheetTile MakeTile(LocalizedImage image) {
  constexpr int kPoseTileWidthPx = 800;
  SheetTile tile;
  tile.title = std::move(image.title);
  tile.caption = {std::move(image.caption)};
  tile.picture = ShrinkImage(image.picture, kPoseTileWidthPx);
  const double scale =
      static_cast<double>(tile.picture.size.width) / image.picture.size.width;
  for (size_t k = 0; k < image.boards.size(); ++k) {
    const Board& board = *image.boards[k];
    const PixelCurve empty(*image.camera, image.camera_from_board[k], scale);
    if (!board.IsPointSet()) tile.curves.push_back(LatticeCurves(board, empty));
    for (int axis = 0; axis < 3; ++axis)
      tile.curves.push_back(AxisCurve(axis, AxisLength(board), empty));
  }
  return tile;
}

}  // namespace

Image PoseSheet(std::vector<LocalizedImage> images) {
  SheetRow row;
  for (LocalizedImage& image : images)
    row.tiles.push_back(MakeTile(std::move(image)));
  return ContactSheet({row}, {{kAreaColor, false, "reprojected target"},
                              {kAxisColors[0], false, "x axis"},
                              {kAxisColors[1], false, "y axis"},
                              {kAxisColors[2], false, "z axis"}});
}

}  // namespace raygrid
