#include "shutter/board_tracks.h"

#include <Eigen/Geometry>
#include <map>
#include <utility>

namespace raygrid {
namespace {

using GetViewPose = std::map<std::pair<std::string, int>, Pose>;

// Returns half of the longer side of the points' bounding rectangle, and the
// centre of that rectangle.
std::pair<double, Eigen::Vector2d> ComputeHalfExtentAndCenter(
    const Board& board) {
  Eigen::AlignedBox2d around;
  for (const Eigen::Vector3d& point : board.points)
    around.extend(point.head<2>());
  return {around.sizes().maxCoeff() / 2, around.center()};
}

std::vector<TrackPoint> CollectPoints(const Board& board,
                                      const std::vector<Feature>& features,
                                      size_t image) {
  const auto& [half_m, center] = ComputeHalfExtentAndCenter(board);
  std::vector<TrackPoint> points;
  for (size_t k = 0; k < features.size(); ++k)
    if (features[k].board == board.id) {
      const Eigen::Vector3d& point =
          board.points[board.PointIndex(features[k].column, features[k].row)];
      points.push_back({point, features[k].pixel,
                        (point.head<2>() - center) / half_m, image, k});
    }
  return points;
}

BoardTrack MakeTrack(const MovingViews& views, const Board& board,
                     const GetViewPose& poses) {
  std::map<double, std::pair<size_t, Pose>> frames;
  const std::vector<ImageFeatures>& images = views.dataset->images;
  for (size_t i = 0; i < images.size(); ++i) {
    const auto time = views.times->find(images[i].image);
    const auto pose = poses.find({images[i].image, board.id});
    if (time != views.times->end() && pose != poses.end())
      frames.insert({time->second, {i, pose->second}});
  }
  BoardTrack track;
  track.half_m = ComputeHalfExtentAndCenter(board).first;
  for (const auto& [time_s, frame] : frames) {
    track.times_s.push_back(time_s);
    track.poses.push_back(frame.second);
    track.points.push_back(
        CollectPoints(board, images[frame.first].features, frame.first));
  }
  track.stencils = MakeStencils(track.times_s);
  return track;
}

}  // namespace

std::vector<BoardTrack> MakeTracks(const MovingViews& views) {
  GetViewPose poses;
  for (const BoardPose& pose : views.poses)
    poses[{pose.image, pose.board}] = pose.camera_from_board;
  std::vector<BoardTrack> tracks;
  for (const Board& board : views.pattern->boards) {
    tracks.push_back(MakeTrack(views, board, poses));
    if (tracks.back().stencils.empty()) tracks.pop_back();
  }
  return tracks;
}

}  // namespace raygrid
