#include "dataset/stack_node.h"

#include <fmt/format.h>

#include <string>

#include "dataset/deviation_node.h"
#include "dataset/error.h"
#include "dataset/yaml_file.h"

namespace raygrid {
namespace {

CameraCondition ParseCondition(const std::string& name) {
  for (const CameraCondition condition :
       {CameraCondition::kLensPosition, CameraCondition::kTemperature})
    if (name == ConditionName(condition)) return condition;
  throw InputError("stack: unknown condition '" + name + "'");
}

void ParseTerm(const YAML::Node& node, BSplineSurface* term) {
  RequireYamlList(node, "stack: one of changes", 2 * term->num_points());
  int index = 0;
  for (Eigen::Vector2d& point : term->points()) {
    point.x() = YamlNumber(node[index++], "stack: changes");
    point.y() = YamlNumber(node[index++], "stack: changes");
  }
}

std::vector<StackDeviation> ParseStackDeviations(const YAML::Node& node) {
  std::vector<StackDeviation> deviations;
  for (const YAML::Node& entry : node) {
    deviations.push_back({YamlNumber(entry["at"], "stack: deviations: at"),
                          ParseDeviations(entry)});
    if (deviations.size() > 1 &&
        !(deviations.back().value > deviations[deviations.size() - 2].value))
      throw InputError("stack: deviations are not in ascending order");
  }
  return deviations;
}

}  // namespace

std::optional<StackOfCameras> ParseStack(const YAML::Node& node,
                                         const CameraModel& camera) {
  if (!node) return std::nullopt;
  const auto* grid = dynamic_cast<const CentralGeneric*>(&camera);
  if (!grid)
    throw InputError("stack: only a central-generic camera can have one");
  const CameraCondition condition =
      ParseCondition(node["condition"].as<std::string>());
  const YAML::Node range = node["range"];
  RequireYamlList(range, "stack: range", 2);
  const double low = YamlNumber(range[0], "stack: range");
  const double high = YamlNumber(range[1], "stack: range");
  if (!(low < high)) throw InputError("stack: range is not ascending");
  const YAML::Node changes = node["changes"];
  if (!changes.IsSequence() || changes.size() < 1 ||
      changes.size() > CameraStack::kMaxOrder)
    throw InputError(fmt::format("stack: changes are not 1 to {} terms",
                                 CameraStack::kMaxOrder));
  const int order = static_cast<int>(changes.size());
  StackOfCameras stack = {CameraStack(condition, low, high, *grid, order), {}};
  for (int k = 0; k < order; ++k)
    ParseTerm(changes[k], &stack.cameras.terms()[k + 1]);
  stack.deviations = ParseStackDeviations(node["deviations"]);
  return stack;
}

void EmitStack(const StackOfCameras& stack, YAML::Emitter* out) {
  const CameraStack& cameras = stack.cameras;
  *out << YAML::Key << "stack" << YAML::Value << YAML::BeginMap << YAML::Key
       << "condition" << YAML::Value << ConditionName(cameras.condition())
       << YAML::Key << "range" << YAML::Value << YAML::Flow << YAML::BeginSeq
       << fmt::format("{:.17g}", cameras.low())
       << fmt::format("{:.17g}", cameras.high()) << YAML::EndSeq << YAML::Key
       << "changes" << YAML::Value << YAML::BeginSeq;
  for (int k = 1; k <= cameras.order(); ++k) {
    *out << YAML::Flow << YAML::BeginSeq;
    for (const Eigen::Vector2d& point : cameras.terms()[k].points())
      *out << fmt::format("{:.12f}", point.x())
           << fmt::format("{:.12f}", point.y());
    *out << YAML::EndSeq;
  }
  *out << YAML::EndSeq << YAML::Key << "deviations" << YAML::Value
       << YAML::BeginSeq;
  for (const StackDeviation& deviation : stack.deviations) {
    *out << YAML::BeginMap << YAML::Key << "at" << YAML::Value
         << fmt::format("{:.17g}", deviation.value);
    EmitDeviations(deviation.lattice, out);
    *out << YAML::EndMap;
  }
  *out << YAML::EndSeq << YAML::EndMap;
}

}  // namespace raygrid
