#include "dataset/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "dataset/error.h"

namespace raygrid {
namespace {

std::string Trim(const std::string& text) {
  const char* spaces = " \t\r";
  const size_t first = text.find_first_not_of(spaces);
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(spaces) - first + 1);
}

std::vector<std::string> Split(const std::string& line) {
  std::vector<std::string> fields;
  size_t start = 0;
  for (;;) {
    const size_t comma = line.find(',', start);
    fields.push_back(Trim(line.substr(start, comma - start)));
    if (comma == std::string::npos) return fields;
    start = comma + 1;
  }
}

template <typename T>
bool Parse(const std::string& text, T* value) {
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, *value);
  return result.ec == std::errc() && result.ptr == end;
}

}  // namespace

CsvTable::CsvTable(const std::string& name, const std::string& text,
                   const std::vector<std::string>& required_columns)
    : name_(name) {
  std::istringstream stream(text);
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    line = Trim(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    std::vector<std::string> fields = Split(line);
    if (header_.empty()) {
      header_ = std::move(fields);
      continue;
    }
    if (fields.size() != header_.size())
      throw InputError(fmt::format(
          "{}, line {}: {} fields where the header has {}; mend the line",
          name_, number, fields.size(), header_.size()));
    rows_.push_back({number, std::move(fields)});
  }
  for (const std::string& column : required_columns)
    if (!HasColumn(column))
      throw InputError(
          fmt::format("{}: no column '{}' in the header; expected {}", name_,
                      column, fmt::join(required_columns, ",")));
}

int CsvTable::ColumnIndex(const std::string& column) const {
  const auto found = std::find(header_.begin(), header_.end(), column);
  return found == header_.end() ? -1
                                : static_cast<int>(found - header_.begin());
}

bool CsvTable::HasColumn(const std::string& column) const {
  return ColumnIndex(column) >= 0;
}

const std::string& CsvTable::Text(size_t row, const std::string& column) const {
  return rows_[row].fields[ColumnIndex(column)];
}

double CsvTable::Number(size_t row, const std::string& column) const {
  double value;
  if (!Parse(Text(row, column), &value) || !std::isfinite(value))
    throw InputError(
        fmt::format("{}, column {}: '{}' is not a finite number; mend or "
                    "remove the line",
                    Place(row), column, Text(row, column)));
  return value;
}

int CsvTable::Integer(size_t row, const std::string& column) const {
  int value;
  if (!Parse(Text(row, column), &value))
    throw InputError(fmt::format(
        "{}, column {}: '{}' is not an integer; mend or remove the line",
        Place(row), column, Text(row, column)));
  return value;
}

std::string CsvTable::Place(size_t row) const {
  return fmt::format("{}, line {}", name_, rows_[row].line);
}

}  // namespace raygrid
