#include "exchange/opencv_boards.h"

#include <fmt/format.h>

#include <cmath>

#include "dataset/error.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace opencv_file {
namespace {

// Returns the name of an image, or a numbered name: OpenCV's samples do not
// store names.
std::string ImageName(const YAML::Node& names, int index) {
  if (names.IsDefined() && names.IsSequence() &&
      index < static_cast<int>(names.size()) && names[index].IsScalar())
    return names[index].as<std::string>();
  return fmt::format("view{:04}", index);
}

// Returns the board size of the file, otherwise the user's. Error messages
// begin with image_points.
ImageSize GetBoardSize(const YAML::Node& root, const ReadRequest& request,
                       int num_points) {
  ImageSize board = request.board.value_or(ImageSize{0, 0});
  if (root["board_width"]) {
    const int width = SidePx(root["board_width"], "board_width");
    const int height = root["board_height"]
                           ? SidePx(root["board_height"], "board_height")
                           : num_points / width;
    if (request.board && *request.board != ImageSize{width, height})
      throw InputError(fmt::format(
          "image_points: the board size {} x {} contradicts --board-size",
          width, height));
    board = {width, height};
  }
  if (board.width == 0)
    throw InputError(
        "image_points: 'board_width' is missing; specify the board size in "
        "corners, such as --board-size 9x6");
  if (int64_t{board.width} * board.height != num_points)
    throw InputError(fmt::format(
        "image_points: {} corners in an image, but the board has {} x {}",
        num_points, board.width, board.height));
  return board;
}

// Reads image_points of OpenCV's calibration sample: one row of corners per
// image, in the order of a board with board_width columns.
std::vector<ImageFeatures> CollectFeatures(const YAML::Node& root,
                                           const StoredMatrix& points,
                                           const ImageSize& board) {
  std::vector<ImageFeatures> images;
  for (int row = 0; row < points.rows; ++row) {
    ImageFeatures& image = images.emplace_back();
    image.image = ImageName(root["image_names"], row);
    for (int k = 0; k < points.columns; ++k) {
      const size_t at = 2 * (static_cast<size_t>(row) * points.columns + k);
      image.features.push_back({0,
                                k % board.width,
                                k / board.width,
                                {points.data[at], points.data[at + 1]}});
    }
  }
  return images;
}

}  // namespace

void ReadBoardFeatures(const YAML::Node& root, const ReadRequest& request,
                       InputCamera* camera) {
  if (!root[kPointsKey]) return;
  const StoredMatrix points = ParseStoredPoints(root[kPointsKey], kPointsKey);
  try {
    camera->features = CollectFeatures(
        root, points, GetBoardSize(root, request, points.columns));
  } catch (const InputError& error) {
    camera->missing_features_reason = error.what();
  }
}

ExchangeContents ReadCornersOnly(const YAML::Node& root,
                                 const ReadRequest& request) {
  const StoredMatrix points = ParseStoredPoints(root[kPointsKey], kPointsKey);
  ExchangeContents contents;
  contents.corners = CollectFeatures(
      root, points, GetBoardSize(root, request, points.columns));
  return contents;
}

std::vector<BoardPose> ReadBoardPoses(const YAML::Node& root) {
  std::vector<BoardPose> poses;
  if (!root["extrinsic_parameters"]) return poses;
  const StoredMatrix rows =
      ParseStoredMatrix(root["extrinsic_parameters"], "extrinsic_parameters");
  if (rows.columns != 6)
    throw InputError("extrinsic_parameters: expected 6 numbers per row");
  std::vector<double> boards(rows.rows, 0);
  if (root["board_ids"]) {
    boards = ParseStoredMatrix(root["board_ids"], "board_ids").data;
    boards.resize(rows.rows, 0);
  }
  for (int row = 0; row < rows.rows; ++row) {
    const Eigen::Map<const Eigen::Matrix<double, 6, 1>> pose(rows.data.data() +
                                                             6 * row);
    if (!(std::abs(boards[row]) < 1e6 && pose.head<3>().norm() < 1e3))
      throw InputError("extrinsic_parameters, board_ids: invalid pose");
    poses.push_back({ImageName(root["image_names"], row),
                     static_cast<int>(boards[row]),
                     {RotationFromVector(pose.head<3>()), pose.tail<3>()}});
  }
  return poses;
}

void AddPoses(const std::vector<BoardPose>& poses, FileStorageText* text) {
  if (poses.empty()) return;
  const int count = static_cast<int>(poses.size());
  StoredMatrix rows = {count, 6, {}}, boards = {1, count, {}};
  std::vector<std::string> names;
  for (const BoardPose& pose : poses) {
    const Eigen::AngleAxisd turn(pose.camera_from_board.rotation);
    const Eigen::Vector3d vector = turn.angle() * turn.axis();
    const Eigen::Vector3d& t = pose.camera_from_board.translation;
    rows.data.insert(rows.data.end(),
                     {vector.x(), vector.y(), vector.z(), t.x(), t.y(), t.z()});
    boards.data.push_back(pose.board);
    names.push_back(pose.image);
  }
  text->Add("image_names", names);
  text->Add("board_ids", boards);
  text->Add("extrinsic_parameters", rows);
}

}  // namespace opencv_file
}  // namespace raygrid
