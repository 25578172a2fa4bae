#include "experiments/experiment_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dataset/csv.h"

namespace raygrid {
namespace {

std::string FormatCell(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  if (const auto* count = std::get_if<int>(&cell))
    return std::to_string(*count);
  return fmt::format("{:.6f}", std::get<double>(cell));
}

using Lines = std::vector<std::vector<std::string>>;

// Returns the header, followed by the rows.
Lines TextTable(const ExperimentResult& result) {
  Lines lines = {result.columns};
  for (const auto& row : result.rows) {
    lines.emplace_back();
    for (const Cell& cell : row) lines.back().push_back(FormatCell(cell));
  }
  return lines;
}

std::vector<size_t> Widths(const Lines& lines) {
  std::vector<size_t> widths(lines[0].size(), 0);
  for (const auto& line : lines)
    for (size_t k = 0; k < line.size(); ++k)
      widths[k] = std::max(widths[k], line[k].size());
  return widths;
}

bool IsText(const ExperimentResult& result, size_t column) {
  return std::holds_alternative<std::string>(result.rows[0][column]);
}

}  // namespace

std::string FormatExperimentText(const ExperimentResult& result) {
  std::string text;
  for (const Condition& condition : result.conditions)
    text += fmt::format("{:<10} {}\n", condition.name, condition.value);
  text += "\n";
  const Lines lines = TextTable(result);
  const std::vector<size_t> widths = Widths(lines);
  for (const auto& line : lines) {
    for (size_t k = 0; k < line.size(); ++k) {
      if (k > 0) text += "  ";
      text += IsText(result, k) ? fmt::format("{:<{}}", line[k], widths[k])
                                : fmt::format("{:>{}}", line[k], widths[k]);
    }
    text += "\n";
  }
  return text;
}

std::string FormatExperimentCsv(const ExperimentResult& result) {
  std::string csv;
  for (const Condition& condition : result.conditions)
    csv += fmt::format("# {}: {}\n", condition.name, condition.value);
  for (std::vector<std::string> line : TextTable(result)) {
    for (std::string& field : line) field = CsvField(field);
    csv += fmt::format("{}\n", fmt::join(line, ","));
  }
  return csv;
}

std::string FormatExperimentJson(const std::string& name,
                                 const ExperimentResult& result) {
  nlohmann::ordered_json json;
  json["experiment"] = name;
  for (const Condition& condition : result.conditions)
    json["conditions"][condition.name] = condition.value;
  json["rows"] = nlohmann::ordered_json::array();
  for (const auto& row : result.rows) {
    nlohmann::ordered_json object;
    for (size_t k = 0; k < row.size(); ++k)
      std::visit([&](const auto& value) { object[result.columns[k]] = value; },
                 row[k]);
    json["rows"].push_back(std::move(object));
  }
  return json.dump(2) + "\n";
}

}  // namespace raygrid
