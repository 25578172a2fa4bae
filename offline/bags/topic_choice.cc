#include "bags/topic_choice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "dataset/edit_distance.h"
#include "dataset/error.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

// Names for errors, the most similar ones first.
std::string ListNearest(const std::string& name,
                        std::vector<std::string> names) {
  constexpr size_t kMaxNames = 5;
  std::stable_sort(names.begin(), names.end(),
                   [&](const std::string& a, const std::string& b) {
                     return CountEdits(name, a) < CountEdits(name, b);
                   });
  const bool is_cut = names.size() > kMaxNames;
  if (is_cut) names.resize(kMaxNames);
  return fmt::format("{}{}", fmt::join(names, ", "), is_cut ? ", ..." : "");
}

// What is known of a topic that is not one of these.
std::string DescribeOther(const Bag& bag, const std::string& name,
                          const std::string& what) {
  for (const BagTopic& topic : bag.topics())
    if (topic.name == name)
      return fmt::format("topic {} has no {}, but {} in {}", Printable(name),
                         what, topic.type, topic.encoding_name);
  return fmt::format("has no topic {}", Printable(name));
}

}  // namespace

size_t ChooseTopic(const Bag& bag, const std::vector<std::string>& names,
                   const std::string& name, const std::string& what) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return found - names.begin();
  if (name.empty() && names.size() == 1) return 0;
  const std::string& path = bag.path();
  if (names.empty())
    throw InputError(
        fmt::format("{}: contains no {}; 'raygrid bag {}' lists "
                    "its topics",
                    path, what, path));
  throw Error(
      ExitCode::kUsage,
      name.empty()
          ? fmt::format("{}: has {} topics with {}; select one with --topic or "
                        "BAG:TOPIC: {}",
                        path, names.size(), what, ListNearest("", names))
          : fmt::format("{}: {}; topics with {}: {}", path,
                        DescribeOther(bag, name, what), what,
                        ListNearest(name, names)));
}

}  // namespace raygrid
