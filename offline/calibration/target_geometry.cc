#include "calibration/target_geometry.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

namespace raygrid {
namespace {

// How far points of a board were estimated from where the pattern says, within
// its plane, after the best motion and scale, RMS.
double MovedM(const Board& given, const Board& found) {
  const auto count = static_cast<Eigen::Index>(given.points.size());
  if (count < 3 || found.points.size() != given.points.size()) return 0;
  Eigen::Matrix3Xd from(3, count), to(3, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    from.col(k) = given.points[k];
    to.col(k) = found.points[k];
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(from, to, true);
  const Eigen::Vector3d normal =
      similarity.topLeftCorner<3, 3>().col(2).normalized();
  const Eigen::Matrix3Xd moves =
      to - (similarity * from.colwise().homogeneous()).topRows<3>();
  return (moves - normal * (normal.transpose() * moves)).norm() /
         std::sqrt(static_cast<double>(count));
}

}  // namespace

void WarnOfOtherGeometry(const Pattern& given, const Pattern& found,
                         Verdict* verdict) {
  constexpr double kMostPart = 0.01;  // of a square
  for (size_t b = 0; b < given.boards.size(); ++b) {
    const Board& board = given.boards[b];
    const double moved_m = MovedM(board, found.boards[b]);
    if (!(moved_m > kMostPart * board.square_m) || board.kind == "points")
      continue;
    if (verdict->word == "pass") verdict->word = "warn";
    verdict->reasons.push_back(fmt::format(
        "the points of board {} are {:.2g} mm (RMS) from where the pattern "
        "says, {:.2g} % of a square: the print is stretched, or the "
        "pattern is of another board, and the camera is wrong by it; measure "
        "the print in both directions, and correct the pattern",
        board.id, 1e3 * moved_m, 100 * moved_m / board.square_m));
  }
}

}  // namespace raygrid
