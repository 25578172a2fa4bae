#include "exchange/tum_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <set>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "dataset/token_lines.h"

namespace raygrid {
namespace {

constexpr size_t kTumColumns = 8;

std::optional<double> ParseNumber(const std::string& word) {
  double number = 0;
  const char* const end = word.data() + word.size();
  const auto [next, fault] = std::from_chars(word.data(), end, number);
  if (fault != std::errc() || next != end || !std::isfinite(number))
    return std::nullopt;
  return number;
}

// ---- Writing ---------------------------------------------------------------

struct TumRow {
  std::string stamp;
  double seconds = 0;
  Pose board_from_camera;
};

bool IsStamp(const std::string& text) {
  return text.find_first_not_of("0123456789.") == std::string::npos &&
         ParseNumber(text);
}

// Returns the name of an image without its extension; images of bags have
// none: their names are stamps with a fraction.
std::string StemOf(const std::string& image) {
  const std::filesystem::path path(image);
  const std::string name = path.filename();
  return IsStamp(name) ? name : path.stem().string();
}

// Whether all image names are numeric timestamps as cameras provide them;
// otherwise, the stamps are 0, 1, ...
bool AreStamps(const std::vector<BoardPose>& poses) {
  return std::all_of(poses.begin(), poses.end(), [](const BoardPose& pose) {
    return IsStamp(StemOf(pose.image));
  });
}

// Throws if there are several targets: a trajectory has one pose per time
// stamp.
void RequireSingleBoard(const PoseTable& table) {
  for (const BoardPose& pose : table.poses)
    if (pose.board != table.poses.front().board)
      throw InputError(fmt::format(
          "{}: contains poses of boards {} and {}, but a trajectory has a "
          "single reference frame; keep the poses of one board",
          table.path, table.poses.front().board, pose.board));
}

std::vector<TumRow> MakeTumRows(const PoseTable& table) {
  const bool are_stamps = AreStamps(table.poses);
  std::vector<TumRow> rows;
  for (const BoardPose& pose : table.poses) {
    TumRow& row = rows.emplace_back();
    row.stamp =
        are_stamps ? StemOf(pose.image) : std::to_string(rows.size() - 1);
    row.seconds = ParseNumber(row.stamp).value_or(0);
    row.board_from_camera = pose.camera_from_board.Inverse();
  }
  std::stable_sort(
      rows.begin(), rows.end(),
      [](const TumRow& a, const TumRow& b) { return a.seconds < b.seconds; });
  for (size_t k = 1; k < rows.size(); ++k)
    if (rows[k].seconds == rows[k - 1].seconds)
      throw InputError(
          fmt::format("{}: duplicate timestamp {}", table.path, rows[k].stamp));
  return rows;
}

TableOutput WriteTum(const PoseTable& table) {
  RequireSingleBoard(table);
  std::string text =
      "# timestamp tx ty tz qx qy qz qw: camera in the board's frame, metres\n";
  for (const TumRow& row : MakeTumRows(table)) {
    const Eigen::Vector3d& t = row.board_from_camera.translation;
    const Eigen::Quaterniond& q = row.board_from_camera.rotation;
    text += fmt::format("{} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n",
                        row.stamp, t.x() + 0.0, t.y() + 0.0, t.z() + 0.0,
                        q.x() + 0.0, q.y() + 0.0, q.z() + 0.0, q.w() + 0.0);
  }
  return {
      {{table.output, text}},
      fmt::format("{} poses of the camera in the board's frame; timestamps {}",
                  table.poses.size(),
                  AreStamps(table.poses)
                      ? "from the image names"
                      : "numbered from 0 in the order of the file")};
}

// ---- Reading ---------------------------------------------------------------

// Whether the first line that is not a comment has eight numbers that end with
// a unit quaternion, which excludes lines of intrinsics.
bool IsTum(const std::string& bytes) {
  constexpr size_t kMaxBytes = 1000;
  size_t at = 0;
  while (at < bytes.size() && (bytes[at] == '#' || bytes[at] == '\n')) {
    at = bytes.find('\n', at);
    if (at != std::string::npos) ++at;
  }
  if (at >= bytes.size()) return false;
  const std::string line =
      bytes.substr(at, std::min(bytes.find('\n', at) - at, kMaxBytes));
  constexpr double kNormTolerance = 0.1;  // tolerance of the norm; files may
                                          // have few digits
  std::istringstream words(line);
  std::vector<double> numbers;
  for (std::string word; words >> word;) {
    const auto number = ParseNumber(word);
    if (!number) return false;
    numbers.push_back(*number);
  }
  return numbers.size() == kTumColumns &&
         std::abs(std::hypot(std::hypot(numbers[4], numbers[5]),
                             std::hypot(numbers[6], numbers[7])) -
                  1) < kNormTolerance;
}

// Formats a timestamp as an image name with plain digits: programs also write
// stamps such as 1.5e+09.
std::string MakeImageName(const std::string& word, double stamp) {
  constexpr double kMaxDigits = 1e15;
  const bool has_exponent = word.find_first_of("eE") != std::string::npos;
  return has_exponent && std::abs(stamp) < kMaxDigits ? fmt::format("{}", stamp)
                                                      : word;
}

std::vector<BoardPose> ReadTum(const std::string& path,
                               const std::string& bytes) {
  constexpr double kRounding = 1e-2;
  TokenLines line(path, bytes, "a TUM trajectory");
  std::vector<BoardPose> poses;
  std::set<double> stamps;
  while (line.NextNonEmpty()) {
    if (line.size() != kTumColumns)
      line.ThrowError(
          fmt::format("has {} fields, expected timestamp tx ty tz qx qy qz qw",
                      line.size()));
    const auto number = [&](size_t k) { return line.Get<double>(k); };
    if (!stamps.insert(number(0)).second)
      line.ThrowError(fmt::format("duplicate timestamp {}", line.Text(0)));
    const Eigen::Quaterniond rotation(number(7), number(4), number(5),
                                      number(6));
    if (!(std::abs(rotation.norm() - 1) < kRounding))
      line.ThrowError("qx qy qz qw must be a unit quaternion");
    const Pose board_from_camera = {rotation.normalized(),
                                    {number(1), number(2), number(3)}};
    poses.push_back({MakeImageName(line.Text(0), number(0)), 0,
                     board_from_camera.Inverse()});
  }
  return poses;
}

}  // namespace

TableFormat MakeTumFormat() {
  TableFormat format;
  format.name = "tum";
  format.holds =
      "TUM trajectory: timestamp, position and quaternion of the camera in the "
      "board's frame, per line";
  format.write_poses = WriteTum;
  format.recognizes = IsTum;
  format.read_poses = ReadTum;
  return format;
}

}  // namespace raygrid
