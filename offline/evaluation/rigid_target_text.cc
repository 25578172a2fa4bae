#include "evaluation/rigid_target_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace raygrid {
namespace {

// RMS deviations of board pairs over all their frames, and the expected
// deviations.
struct PairDeviation {
  double square_m2 = 0, square_rad2 = 0;
  double expected_m2 = 0, expected_rad2 = 0;
  int num_frames = 0;

  void Add(const BoardPair& pair) {
    const double count = pair.num_frames;
    square_m2 += count * pair.deviation_m * pair.deviation_m;
    square_rad2 += count * pair.deviation_rad * pair.deviation_rad;
    expected_m2 += count * pair.expected_m * pair.expected_m;
    expected_rad2 += count * pair.expected_rad * pair.expected_rad;
    num_frames += pair.num_frames;
  }
  std::string Text() const {
    const double count = std::max(1, num_frames);
    constexpr double kDegrees = 180 / M_PI;
    return fmt::format(
        "{:.3f} mm and {:.3f} degrees RMS ({} pairs of views; expected from "
        "noise: {:.3f} mm and {:.3f} degrees)",
        1e3 * std::sqrt(square_m2 / count),
        kDegrees * std::sqrt(square_rad2 / count), num_frames,
        1e3 * std::sqrt(expected_m2 / count),
        kDegrees * std::sqrt(expected_rad2 / count));
  }
};

}  // namespace

std::string FormatList(const std::vector<int>& ids) {
  const std::vector<int> first(ids.begin(), ids.end() - 1);
  return fmt::format("{} and {}", fmt::join(first, ", "), ids.back());
}

std::vector<std::string> DescribeRigidTargets(
    const std::vector<RigidTarget>& rigid_targets,
    const std::vector<BoardPair>& pairs) {
  std::vector<std::string> sentences;
  for (const RigidTarget& body : rigid_targets) {
    const std::set<int> ids(body.boards.begin(), body.boards.end());
    PairDeviation deviation;
    std::set<int> compared;
    size_t num_pairs = 0;
    for (const BoardPair& pair : pairs) {
      if (!pair.fixed || !ids.count(pair.first) || !ids.count(pair.second))
        continue;
      deviation.Add(pair);
      compared.insert({pair.first, pair.second});
      ++num_pairs;
    }
    std::string& sentence = sentences.emplace_back(fmt::format(
        "boards {} are a rigid multi-board target, estimated as one body",
        FormatList(body.boards)));
    if (num_pairs > 0)
      sentence += "; relative poses repeat to " + deviation.Text();
    // The pairs do not connect all boards.
    if (compared.size() < ids.size() || num_pairs + 1 < ids.size())
      sentence +=
          "; boards that no camera observes together are assumed to be fixed";
  }
  std::set<int> moving;
  PairDeviation deviation;
  for (const BoardPair& pair : pairs) {
    if (pair.fixed) continue;
    moving.insert({pair.first, pair.second});
    deviation.Add(pair);
  }
  if (!moving.empty())
    sentences.push_back(fmt::format(
        "boards {} {} by {}",
        FormatList(std::vector<int>(moving.begin(), moving.end())),
        moving.size() > 2 ? "or some of them move relative to each other"
                          : "move relative to each other",
        deviation.Text()));
  return sentences;
}

}  // namespace raygrid
