#include "requested_operating_point.h"

#include <fmt/format.h>

#include "camera_values.h"
#include "dataset/error.h"
#include "key_options.h"

namespace raygrid {
namespace {

double ParseValueAt(const std::string& text) {
  return ParseNumbers("--at", text, 1,
                      "2.5 or lens_position=2.5,temperature=40")
      .front();
}

// Returns an example of --at for a camera with these ranges.
std::string ExampleAt(const std::vector<OperatingRange>& ranges) {
  RequestedOperatingPoint example;
  for (const OperatingRange& range : ranges)
    example.named[range.condition] = range.Center();
  return example.Text();
}

[[noreturn]] void ThrowInvalidOperatingPoint(const RequestedOperatingPoint& at,
                                             const std::string& name,
                                             const std::string& why) {
  throw Error(ExitCode::kUsage,
              fmt::format("{}: {}: {}", name, at.Text(), why));
}

}  // namespace

std::string RequestedOperatingPoint::Text() const {
  if (alone) return fmt::format("--at {:g}", *alone);
  std::string text;
  for (const auto& [condition, value] : named)
    text += fmt::format("{}{}={:g}", text.empty() ? "--at " : ",",
                        OperatingParameterName(condition), value);
  return text;
}

RequestedOperatingPoint ParseRequestedOperatingPoint(const std::string& text) {
  RequestedOperatingPoint at;
  if (text.find('=') == std::string::npos) {
    at.alone = ParseValueAt(text);
    return at;
  }
  for (const std::string& part : SplitAtKeys(text)) {
    const NamedValue given = ParseNamedValue(part);
    const auto condition = FindOperatingParameter(given.name);
    if (!condition)
      throw Error(ExitCode::kUsage,
                  fmt::format("--at {}: unknown quantity '{}'; expected "
                              "lens_position or temperature",
                              text, given.name));
    if (!at.named.emplace(*condition, ParseValueAt(given.value)).second)
      throw Error(
          ExitCode::kUsage,
          fmt::format("--at {}: {} is specified twice", text, given.name));
  }
  return at;
}

FixedOperatingPoint FixRequestedPoint(const RequestedOperatingPoint& at,
                                      const std::vector<OperatingRange>& ranges,
                                      const std::string& name) {
  FixedOperatingPoint held(ranges.size());
  if (at.alone && ranges.size() > 1)
    ThrowInvalidOperatingPoint(
        at, name,
        "varies with two quantities; specify both, such as " +
            ExampleAt(ranges));
  if (at.alone) held[0] = at.alone;
  for (const auto& [condition, value] : at.named) {
    size_t r = 0;
    while (r < ranges.size() && ranges[r].condition != condition) ++r;
    if (r == ranges.size())
      ThrowInvalidOperatingPoint(
          at, name,
          fmt::format("varies with {} only",
                      OperatingParameterName(ranges[0].condition)));
    held[r] = value;
  }
  return held;
}

RequestedOperatingPoint FilterByRanges(
    const RequestedOperatingPoint& at,
    const std::vector<OperatingRange>& ranges) {
  RequestedOperatingPoint own = {at.alone, {}};
  for (const OperatingRange& range : ranges) {
    const auto given = at.named.find(range.condition);
    if (given != at.named.end()) own.named.insert(*given);
  }
  return own;
}

FixedOperatingPoint FixRequestedPointInRange(
    const RequestedOperatingPoint& at,
    const std::vector<OperatingRange>& ranges, const std::string& name) {
  FixedOperatingPoint held = FixRequestedPoint(at, ranges, name);
  for (size_t r = 0; r < ranges.size(); ++r)
    if (held[r] && !ranges[r].Contains(*held[r]))
      ThrowInvalidOperatingPoint(
          at, name, "outside the calibrated range, " + ranges[r].Text());
  return held;
}

std::string ToString(const std::vector<OperatingRange>& ranges) {
  std::string text;
  for (const OperatingRange& range : ranges)
    text += (text.empty() ? "" : " and ") + range.Text();
  return text;
}

}  // namespace raygrid
