#include "dataset/operating_point_node.h"

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "dataset/error.h"
#include "dataset/uncertainty_node.h"
#include "dataset/yaml_file.h"

namespace raygrid {
namespace {

OperatingParameter ParseOperatingParameter(const std::string& name) {
  const auto condition = FindOperatingParameter(name);
  if (!condition)
    throw InputError("operating-point model ('stack'): unknown quantity '" +
                     name +
                     "' in 'condition'; expected lens_position or temperature");
  return *condition;
}

// Returns the nodes of a model's parameters of the operating point; a single
// parameter is in the model's own node.
std::vector<YAML::Node> SplitOperatingPointNodes(const YAML::Node& node) {
  const YAML::Node several = node["conditions"];
  if (!several) return {node};
  RequireYamlList(several, "operating-point model ('stack'): 'conditions'",
                  OperatingPointModel::kMaxConditions);
  return {several.begin(), several.end()};
}

OperatingRange ParseRange(const YAML::Node& node) {
  const YAML::Node range = node["range"], name = node["condition"];
  if (!name || !name.IsScalar())
    throw InputError(
        "operating-point model ('stack'): missing 'condition'; expected "
        "lens_position or temperature");
  const OperatingParameter condition = ParseOperatingParameter(name.Scalar());
  const std::string what = fmt::format(
      "operating-point model ('stack'): range of {}", name.Scalar());
  if (!range || !range.IsSequence() || range.size() != 2)
    throw InputError(what +
                     ": expected the calibrated range as 'range: [MIN, MAX]'");
  const OperatingRange parsed = {condition, YamlNumber(range[0], what),
                                 YamlNumber(range[1], what)};
  if (!(parsed.low < parsed.high))
    throw InputError(fmt::format(
        "{}: {:g} is not less than {:g}; specify the lower value first", what,
        parsed.low, parsed.high));
  return parsed;
}

int ParseOrder(const YAML::Node& node) {
  const YAML::Node changes = node["changes"];
  const size_t count = changes && changes.IsSequence() ? changes.size() : 0;
  if (count < 1 || count > OperatingPointModel::kMaxOrder)
    throw InputError(fmt::format(
        "operating-point model ('stack'): 'changes' with {}: {}, expected 1 to "
        "{} lists of numbers; use the file as written by raygrid calibrate",
        node["condition"].Scalar(),
        !changes               ? std::string("none")
        : changes.IsSequence() ? fmt::format("a list of {}", count)
                               : "not a list",
        OperatingPointModel::kMaxOrder));
  return static_cast<int>(count);
}

// what: name of the list for error messages.
void ParseTerm(const YAML::Node& node, const std::string& what,
               BSplineSurface* term) {
  const size_t expected = 2 * term->points().size();
  if (!node.IsSequence() || node.size() != expected)
    throw InputError(
        fmt::format("{}: {}, expected a pair per control point, {} numbers; "
                    "use the file as written by raygrid calibrate",
                    what,
                    node.IsSequence() ? fmt::format("a list of {}", node.size())
                                      : std::string("not a list"),
                    expected));
  int index = 0;
  for (Eigen::Vector2d& point : term->points()) {
    point.x() = YamlNumber(node[index++], what);
    point.y() = YamlNumber(node[index++], what);
  }
}

// Parses an operating point: a number, or a list if there are several
// parameters.
OperatingPoint ParseValues(const YAML::Node& node, size_t count) {
  const char* const kName =
      "operating-point model ('stack'): 'at' in 'deviations'";
  if (count == 1) return {YamlNumber(node, kName)};
  RequireYamlList(node, kName, static_cast<int>(count));
  OperatingPoint values;
  for (const YAML::Node& value : node)
    values.push_back(YamlNumber(value, kName));
  return values;
}

std::vector<OperatingPointUncertainty> ParseOperatingPointStdDevs(
    const YAML::Node& node, size_t num_parameters) {
  std::vector<OperatingPointUncertainty> deviations;
  for (const YAML::Node& entry : node) {
    deviations.push_back({ParseValues(entry["at"], num_parameters),
                          ParseUncertaintyLattice(entry)});
    if (deviations.size() > 1 &&
        !(deviations.back().values > deviations[deviations.size() - 2].values))
      throw InputError(
          "operating-point model ('stack'): standard deviations ('deviations') "
          "must be in ascending order of 'at'");
  }
  return deviations;
}

// ---- Writing ---------------------------------------------------------------

void EmitNumbers(const std::vector<double>& numbers, YAML::Emitter* out) {
  *out << YAML::Flow << YAML::BeginSeq;
  for (const double number : numbers) *out << fmt::format("{:.17g}", number);
  *out << YAML::EndSeq;
}

// Writes the keys of one parameter of the operating point to the current map.
void EmitOperatingParameter(const OperatingPointModel& cameras, size_t range,
                            YAML::Emitter* out) {
  const OperatingRange& over = cameras.ranges()[range];
  *out << YAML::Key << "condition" << YAML::Value
       << OperatingParameterName(over.condition) << YAML::Key << "range"
       << YAML::Value;
  EmitNumbers({over.low, over.high}, out);
  *out << YAML::Key << "changes" << YAML::Value << YAML::BeginSeq;
  const int first = cameras.FirstTerm(range);
  for (int k = first; k < first + cameras.orders()[range]; ++k) {
    *out << YAML::Flow << YAML::BeginSeq;
    for (const Eigen::Vector2d& point : cameras.terms()[k].points())
      *out << fmt::format("{:.12f}", point.x())
           << fmt::format("{:.12f}", point.y());
    *out << YAML::EndSeq;
  }
  *out << YAML::EndSeq;
}

}  // namespace

std::optional<OperatingPointCalibration> ParseOperatingPointModel(
    const YAML::Node& node, const CameraModel& camera) {
  if (!node) return std::nullopt;
  if (camera.Name() != models::kCentralGeneric)
    throw InputError(
        fmt::format("operating-point model ('stack'): requires a {} camera",
                    models::kCentralGeneric));
  const std::vector<YAML::Node> nodes = SplitOperatingPointNodes(node);
  std::vector<OperatingRange> ranges;
  std::vector<int> orders;
  for (const YAML::Node& condition : nodes) {
    ranges.push_back(ParseRange(condition));
    orders.push_back(ParseOrder(condition));
  }
  if (ranges.size() > 1 && !(ranges[0].condition < ranges[1].condition))
    throw InputError(
        "operating-point model ('stack'): 'conditions' must be lens_position, "
        "then temperature");
  OperatingPointCalibration stack = {
      OperatingPointModel(ranges, orders, MakeCentral(camera)), {}};
  int term = 1;
  for (const YAML::Node& condition : nodes) {
    int number = 0;
    for (const YAML::Node& change : condition["changes"])
      ParseTerm(
          change,
          fmt::format(
              "operating-point model ('stack'): list {} of 'changes' with {}",
              ++number, condition["condition"].Scalar()),
          &stack.cameras.terms()[term++]);
  }
  stack.deviations =
      ParseOperatingPointStdDevs(node["deviations"], ranges.size());
  return stack;
}

void EmitOperatingPointModel(const OperatingPointCalibration& stack,
                             YAML::Emitter* out) {
  const OperatingPointModel& cameras = stack.cameras;
  const size_t num_parameters = cameras.ranges().size();
  *out << YAML::Key << "stack" << YAML::Value << YAML::BeginMap;
  if (num_parameters == 1) {
    EmitOperatingParameter(cameras, 0, out);
  } else {
    *out << YAML::Key << "conditions" << YAML::Value << YAML::BeginSeq;
    for (size_t r = 0; r < num_parameters; ++r) {
      *out << YAML::BeginMap;
      EmitOperatingParameter(cameras, r, out);
      *out << YAML::EndMap;
    }
    *out << YAML::EndSeq;
  }
  *out << YAML::Key << "deviations" << YAML::Value << YAML::BeginSeq;
  for (const OperatingPointUncertainty& deviation : stack.deviations) {
    *out << YAML::BeginMap << YAML::Key << "at" << YAML::Value;
    if (num_parameters == 1)
      *out << fmt::format("{:.17g}", deviation.values[0]);
    else
      EmitNumbers(deviation.values, out);
    EmitUncertaintyLattice(deviation.lattice, out);
    *out << YAML::EndMap;
  }
  *out << YAML::EndSeq << YAML::EndMap;
}

}  // namespace raygrid
