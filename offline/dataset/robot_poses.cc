#include "dataset/robot_poses.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string_view>

#include "dataset/csv.h"
#include "dataset/dataset.h"
#include "dataset/error.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

// Rounded numbers of a file; larger deviations are reported, and those above
// the maximum are errors.
constexpr double kRotationRounding = 1e-4, kMaxRotationError = 0.01;

bool ParseFinite(std::string_view text, double* value) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const char* const end = text.data() + text.size();
  const auto [next, error] = std::from_chars(text.data(), end, *value);
  return error == std::errc() && next == end && std::isfinite(*value);
}

// Whether a word is a number, which may be infinite or none (NaN).
bool IsNumber(std::string_view text) {
  double value = 0;
  return ParseFinite(text, &value) || text == "nan" || text == "inf" ||
         text == "-nan" || text == "-inf" || text == "NaN";
}

// ---- Rotations -------------------------------------------------------------

void CheckRotationError(const std::string& place, const char* what,
                        double error, int* num_normalized) {
  if (!(error <= kMaxRotationError))
    throw InputError(fmt::format("{}: {} by {:.3g} %; at most 1 % is accepted",
                                 place, what, 100 * error));
  if (error > kRotationRounding) ++*num_normalized;
}

Eigen::Quaterniond CheckQuaternion(const std::string& place,
                                   const Eigen::Quaterniond& quaternion,
                                   int* num_normalized) {
  CheckRotationError(place, "the quaternion's length differs from 1",
                     std::abs(quaternion.norm() - 1), num_normalized);
  return quaternion.normalized();
}

Eigen::Quaterniond CheckMatrix(const std::string& place,
                               const Eigen::Matrix3d& matrix,
                               int* num_normalized) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double error =
      (svd.singularValues() - Eigen::Vector3d::Ones()).cwiseAbs().maxCoeff();
  CheckRotationError(place, "the matrix differs from a rotation", error,
                     num_normalized);
  const Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  if (rotation.determinant() < 0)
    throw InputError(place + ": the matrix is a reflection, not a rotation");
  return Eigen::Quaterniond(rotation);
}

// Adds poses in the units and the convention of a file.
class PoseCollector {
 public:
  explicit PoseCollector(const RobotPoseOptions& options) : options_(options) {}

  void Add(const std::string& place, const std::string& label, Pose pose) {
    if (robot_.poses.size() == kMaxPoses)
      throw InputError(fmt::format("{}: more than {} poses", place, kMaxPoses));
    pose.translation *= options_.unit_m;
    if (options_.is_inverted) pose = pose.Inverse();
    robot_.poses.push_back({label, pose});
  }
  // The quaternion is qx, qy, qz, qw, as Eigen stores it.
  void AddQuaternion(const std::string& place, const std::string& label,
                     const Eigen::Vector3d& translation,
                     const Eigen::Vector4d& xyzw) {
    Add(place, label,
        {CheckQuaternion(place, Eigen::Quaterniond(xyzw),
                         &robot_.num_normalized),
         translation});
  }
  // The rows of a 3 x 4 or 4 x 4 matrix.
  void AddMatrix(const std::string& place, const std::string& label,
                 const std::vector<double>& values) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(
        values.data());
    constexpr double kLast[] = {0, 0, 0, 1}, kRounding = 1e-6;
    for (size_t k = 12; k < values.size(); ++k)
      if (!(std::abs(values[k] - kLast[k - 12]) < kRounding))
        throw InputError(place +
                         ": the last row of a 4 x 4 matrix must be 0 0 0 1; "
                         "matrices are stored row by row");
    Add(place, label,
        {CheckMatrix(place, matrix.leftCols<3>(), &robot_.num_normalized),
         matrix.col(3)});
  }

  RobotPoses TakePoses() { return std::move(robot_); }

 private:
  RobotPoseOptions options_;
  RobotPoses robot_;
};

// ---- CSV with a header -----------------------------------------------------

std::string LowerCase(std::string text) {
  for (char& c : text)
    c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool EndsWithAny(const std::string& text,
                 const std::vector<const char*>& ends) {
  return std::any_of(ends.begin(), ends.end(), [&](std::string_view end) {
    return text.size() >= end.size() &&
           std::string_view(text).substr(text.size() - end.size()) == end;
  });
}

bool ContainsAny(const std::string& text,
                 const std::vector<const char*>& parts) {
  return std::any_of(parts.begin(), parts.end(), [&](const char* part) {
    return text.find(part) != std::string::npos;
  });
}

// The columns of a header: the label, or seconds and nanoseconds, and tx, ty,
// tz, qx, qy, qz, qw.
struct PoseColumns {
  std::string label, seconds, nanoseconds;
  std::array<std::string, 7> values;
};

// Returns the index into PoseColumns::values; -1 for other columns.
int ValueIndex(const std::string& column) {
  std::string name = LowerCase(column.substr(0, column.find('[')));
  while (!name.empty() && name.back() == ' ') name.pop_back();
  if (name.empty() || ContainsAny(name, {"twist", "vel", "cov", "joint"}))
    return -1;
  const char axis = name.back();
  name.pop_back();
  if (ContainsAny(name, {"orientation", "rotation", "quat"}) ||
      name.rfind('q', 0) == 0) {
    const size_t index = std::string_view("xyzw").find(axis);
    return index == std::string::npos ? -1 : 3 + static_cast<int>(index);
  }
  const size_t index = std::string_view("xyz").find(axis);
  const bool is_position = name.empty() || name == "t" || name == "p" ||
                           name == "t_" || name == "p_" ||
                           ContainsAny(name, {"pos", "trans"});
  return index == std::string::npos || !is_position ? -1
                                                    : static_cast<int>(index);
}

void AddLabelColumn(const std::string& column, PoseColumns* columns) {
  const std::string name =
      LowerCase(column.substr(0, column.find_first_of(" [")));
  if (EndsWithAny(name, {"nsecs", "nsec", "nanosec"}))
    columns->nanoseconds = column;
  else if (EndsWithAny(name, {"secs", "sec"}))
    columns->seconds = column;
  else if (name == "image" || name == "name" || name == "file" ||
           name == "filename" ||
           (columns->label.empty() &&
            (name == "t" || name == "%time" || name == "stamp" ||
             EndsWithAny(name, {"time", "timestamp", "time_s"}))))
    columns->label = column;
}

PoseColumns FindPoseColumns(const std::string& path, const CsvReader& table) {
  constexpr const char* kNames[] = {"x", "y", "z", "qx", "qy", "qz", "qw"};
  PoseColumns columns;
  for (const std::string& column : table.columns()) {
    const int index = ValueIndex(column);
    if (index < 0) {
      AddLabelColumn(column, &columns);
      continue;
    }
    if (!columns.values[index].empty())
      throw InputError(fmt::format("{}: columns '{}' and '{}' are both {}",
                                   path, columns.values[index], column,
                                   kNames[index]));
    columns.values[index] = column;
  }
  for (size_t k = 0; k < columns.values.size(); ++k)
    if (columns.values[k].empty())
      throw InputError(fmt::format(
          "{}: no column for {} in the header; expected image or time, x, y, "
          "z, qx, qy, qz, qw",
          path, kNames[k]));
  return columns;
}

std::string GetLabel(const CsvReader& table, const PoseColumns& columns) {
  if (!columns.label.empty()) return table.Text(columns.label);
  if (columns.seconds.empty()) return "";
  const double nanoseconds =
      columns.nanoseconds.empty() ? 0 : table.Number(columns.nanoseconds);
  return fmt::format("{:.9f}",
                     table.Number(columns.seconds) + 1e-9 * nanoseconds);
}

constexpr const char* kSeparators = " \t\r,;";

// Whether columns name all seven numbers of a pose.
bool IsPoseColumnName(const std::vector<std::string>& columns) {
  std::array<bool, 7> is_named = {};
  for (const std::string& column : columns)
    if (const int index = ValueIndex(column); index >= 0)
      is_named[index] = true;
  return std::count(is_named.begin(), is_named.end(), true) == 7;
}

std::vector<std::string> SplitLine(const std::string& line,
                                   const char* separators) {
  std::vector<std::string> words;
  for (size_t k = line.find_first_not_of(separators); k != std::string::npos;) {
    const size_t end = std::min(line.find_first_of(separators, k), line.size());
    words.push_back(line.substr(k, end - k));
    k = line.find_first_not_of(separators, end);
  }
  return words;
}

// Replaces white space between fields by commas.
std::string ReplaceByCommas(const std::string& text) {
  std::string result;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size());
    const auto words = SplitLine(text.substr(at, end - at), kSeparators);
    result += fmt::format("{}\n", fmt::join(words, ","));
    at = end + 1;
  }
  return result;
}

// Returns a CSV table if the text begins with a header, which may be a comment
// or separated by spaces; else an empty text.
std::string FindTable(const std::string& text) {
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size());
    const bool is_comment = text[at] == '#';
    const std::string line =
        text.substr(at + is_comment, end - at - is_comment);
    const bool has_commas = line.find(',') != std::string::npos;
    const auto fields = SplitLine(line, kSeparators);
    const auto words = has_commas ? SplitLine(line, ",") : fields;
    const bool is_header = is_comment
                               ? IsPoseColumnName(words)
                               : fields.size() > 1 && !IsNumber(fields.back());
    if (is_header) {
      // Empty lines keep the numbers of the lines.
      const std::string lines_before(
          static_cast<size_t>(
              std::count(text.begin(),
                         text.begin() + static_cast<std::ptrdiff_t>(at), '\n')),
          '\n');
      const std::string table = lines_before + line + text.substr(end);
      return has_commas ? table : ReplaceByCommas(table);
    }
    if (!is_comment && !fields.empty()) return "";
    at = end + 1;
  }
  return "";
}

void ReadTable(const std::string& path, const std::string& text,
               PoseCollector* collector) {
  CsvReader table(path, text, {});
  table.LimitRows(kMaxPoses);
  const PoseColumns columns = FindPoseColumns(path, table);
  while (table.Next()) {
    std::array<double, 7> values;
    for (size_t k = 0; k < values.size(); ++k)
      values[k] = table.Number(columns.values[k]);
    collector->AddQuaternion(table.Place(), GetLabel(table, columns),
                             {values[0], values[1], values[2]},
                             {values[3], values[4], values[5], values[6]});
  }
}

// ---- Lines of numbers ------------------------------------------------------

struct NumberLine {
  int number = 0;  // of the line in the file
  std::vector<std::string> words;
};

std::vector<NumberLine> SplitLines(const std::string& text) {
  std::vector<NumberLine> lines;
  int number = 0;
  for (size_t at = 0; at < text.size(); ++number) {
    const size_t end = std::min(text.find('\n', at), text.size());
    NumberLine line = {number + 1, {}};
    const std::string_view all = std::string_view(text).substr(at, end - at);
    at = end + 1;
    for (size_t k = all.find_first_not_of(kSeparators);
         k != std::string_view::npos &&
         (!line.words.empty() || all[k] != '#');) {
      const size_t stop =
          std::min(all.find_first_of(kSeparators, k), all.size());
      line.words.emplace_back(all.substr(k, stop - k));
      k = all.find_first_not_of(kSeparators, stop);
    }
    if (!line.words.empty()) lines.push_back(std::move(line));
  }
  return lines;
}

std::vector<double> ParseNumbersFrom(const std::string& place,
                                     const std::vector<std::string>& words,
                                     size_t first) {
  std::vector<double> values;
  for (size_t k = first; k < words.size(); ++k)
    if (!ParseFinite(words[k], &values.emplace_back()))
      throw InputError(fmt::format("{}: '{}' is not a finite number", place,
                                   Printable(words[k])));
  return values;
}

// Appends the rows of a matrix that follow each other; returns their number.
size_t AppendMatrixRows(const std::string& path,
                        const std::vector<NumberLine>& lines, size_t first,
                        std::vector<double>* values) {
  constexpr size_t kRows = 4;
  size_t k = first;
  for (; k < lines.size() && k < first + kRows && lines[k].words.size() == 4;
       ++k)
    for (const double value :
         ParseNumbersFrom(fmt::format("{}, line {}", path, lines[k].number),
                          lines[k].words, 0))
      values->push_back(value);
  return k - first;
}

void ReadLines(const std::string& path, const std::string& text,
               PoseCollector* collector) {
  const std::vector<NumberLine> lines = SplitLines(text);
  for (size_t k = 0; k < lines.size();) {
    const std::vector<std::string>& words = lines[k].words;
    const std::string place = fmt::format("{}, line {}", path, lines[k].number);
    const size_t count = words.size();
    std::vector<double> values;
    const bool is_labelled =
        count == 1 || count == 8 || count == 13 || count == 17;
    const std::string label = is_labelled ? words[0] : "";
    if (count == 1 || count == 4) {
      k += is_labelled;
      const size_t rows = AppendMatrixRows(path, lines, k, &values);
      if (rows != 4)
        throw InputError(fmt::format(
            "{}: {} rows of 4 numbers follow, expected a 4 x 4 matrix", place,
            rows));
      k += rows;
      collector->AddMatrix(place, label, values);
      continue;
    }
    ++k;
    if (count != 7 && count != 12 && count != 16 && !is_labelled)
      throw InputError(fmt::format(
          "{}: {} fields; expected an image name or time and tx ty tz qx qy qz "
          "qw, or the 12 or 16 numbers of a matrix",
          place, count));
    values = ParseNumbersFrom(place, words, is_labelled ? 1 : 0);
    if (values.size() == 7)
      collector->AddQuaternion(place, label, {values[0], values[1], values[2]},
                               {values[3], values[4], values[5], values[6]});
    else
      collector->AddMatrix(place, label, values);
  }
}

}  // namespace

RobotPoses ParseRobotPoses(const std::string& path, const std::string& text,
                           const RobotPoseOptions& options) {
  RequireTextFile(path, text);
  PoseCollector collector(options);
  const std::string table = FindTable(text);
  if (!table.empty())
    ReadTable(path, table, &collector);
  else
    ReadLines(path, text, &collector);
  RobotPoses robot = collector.TakePoses();
  if (robot.poses.empty()) throw InputError(path + ": no poses");
  return robot;
}

}  // namespace raygrid
