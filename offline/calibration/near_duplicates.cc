#include "calibration/near_duplicates.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "calibration/calibration_problem.h"

namespace raygrid {
namespace {

// The features of one board in one camera's image of a frame.
struct ObservedBoard {
  size_t camera;
  int board;
  std::map<std::pair<int, int>, Eigen::Vector2d> pixels;  // by row, column
};

struct FrameSet {
  std::string name;
  bool is_held_out = false;
  size_t num_features = 0;
  std::vector<ObservedBoard> boards;  // one per camera and board; those with
                                      // few features are omitted
};

void AddImage(const ImageFeatures& image, size_t camera, FrameSet* frame_set) {
  std::map<int, ObservedBoard> boards;
  for (const Feature& f : image.features) {
    ObservedBoard& part = boards[f.board];
    part.camera = camera;
    part.board = f.board;
    part.pixels[{f.row, f.column}] = f.pixel;
  }
  for (auto& [board, part] : boards) {
    if (part.pixels.size() < kMinViewFeatures) continue;
    frame_set->num_features += part.pixels.size();
    frame_set->boards.push_back(std::move(part));
  }
}

// Sorts frames by their priority as the representative of a group.
std::vector<FrameSet> SortFrames(const std::vector<Dataset>& cameras,
                                 const std::vector<std::string>& held_out) {
  std::vector<FrameSet> frame_sets;
  std::map<std::string, size_t> index_by_image;
  for (size_t c = 0; c < cameras.size(); ++c) {
    for (const ImageFeatures& image : cameras[c].images) {
      const size_t index =
          index_by_image.emplace(image.image, frame_sets.size()).first->second;
      if (index == frame_sets.size())
        frame_sets.push_back({image.image, false, 0, {}});
      AddImage(image, c, &frame_sets[index]);
    }
  }
  for (const std::string& name : held_out) {
    const auto found = index_by_image.find(name);
    if (found != index_by_image.end())
      frame_sets[found->second].is_held_out = true;
  }
  frame_sets.erase(
      std::remove_if(frame_sets.begin(), frame_sets.end(),
                     [](const FrameSet& i) { return i.boards.empty(); }),
      frame_sets.end());
  std::stable_sort(frame_sets.begin(), frame_sets.end(),
                   [](const FrameSet& a, const FrameSet& b) {
                     return a.num_features > b.num_features;
                   });
  return frame_sets;
}

// Whether the features of a board in one image add no information to those of
// another image.
bool IsDetermined(const ObservedBoard& part, const ObservedBoard& other,
                  double duplicate_px) {
  constexpr double kMinCommonFraction = 0.5, kMaxMovedFraction = 0.1;
  const auto size = static_cast<double>(part.pixels.size());
  size_t num_common = 0, num_moved = 0;
  for (const auto& [place, pixel] : part.pixels) {
    const auto found = other.pixels.find(place);
    if (found == other.pixels.end()) continue;
    ++num_common;
    if ((found->second - pixel).norm() < duplicate_px) continue;
    // Most views differ, and a few moved features suffice to show it.
    if (static_cast<double>(++num_moved) > kMaxMovedFraction * size)
      return false;
  }
  const auto common = static_cast<double>(num_common);
  return common >= kMinCommonFraction * size &&
         static_cast<double>(num_moved) <= kMaxMovedFraction * common;
}

bool IsDetermined(const FrameSet& frame_set, const FrameSet& other,
                  const std::vector<double>& duplicate_px) {
  return std::all_of(
      frame_set.boards.begin(), frame_set.boards.end(),
      [&](const ObservedBoard& part) {
        return std::any_of(
            other.boards.begin(), other.boards.end(),
            [&](const ObservedBoard& seen) {
              return seen.camera == part.camera && seen.board == part.board &&
                     IsDetermined(part, seen, duplicate_px[part.camera]);
            });
      });
}

std::vector<double> ComputeDistancesPx(const std::vector<Dataset>& cameras,
                                       std::optional<double> duplicate_px) {
  std::vector<double> distances_px;
  for (const Dataset& dataset : cameras)
    distances_px.push_back(
        duplicate_px.value_or(DefaultDuplicatePx(dataset.image_size)));
  return distances_px;
}

bool AreAllImagesViews(std::optional<double> duplicate_px) {
  return duplicate_px && !(*duplicate_px > 0);
}

std::set<std::string> CollectDuplicateNames(
    const std::vector<NearDuplicates>& groups) {
  std::set<std::string> names;
  for (const NearDuplicates& group : groups)
    names.insert(group.others.begin(), group.others.end());
  return names;
}

Dataset KeepSelectedImages(const Dataset& dataset,
                           const std::vector<NearDuplicates>& groups,
                           bool others) {
  const std::set<std::string> names = CollectDuplicateNames(groups);
  Dataset selected = {dataset.image_size, {}};
  for (const ImageFeatures& image : dataset.images)
    if ((names.count(image.image) > 0) == others)
      selected.images.push_back(image);
  return selected;
}

}  // namespace

double DefaultDuplicatePx(const ImageSize& size) {
  constexpr double kRelativeLimit = 0.001, kMinPx = 1;
  return std::max(kMinPx, kRelativeLimit * std::max(size.width, size.height));
}

double NearDuplicatePx(const ImageSize& size) {
  constexpr double kRelativeLimit = 0.005, kMinPx = 2;
  return std::max(kMinPx, kRelativeLimit * std::max(size.width, size.height));
}

std::vector<NearDuplicates> FindNearDuplicates(
    const std::vector<Dataset>& cameras,
    const std::vector<std::string>& held_out,
    std::optional<double> duplicate_px) {
  if (AreAllImagesViews(duplicate_px)) return {};
  const std::vector<double> distances_px =
      ComputeDistancesPx(cameras, duplicate_px);
  std::vector<FrameSet> different;
  std::vector<NearDuplicates> groups;
  for (FrameSet& frame_set : SortFrames(cameras, held_out)) {
    size_t k = 0;
    while (k < different.size() &&
           (frame_set.is_held_out != different[k].is_held_out ||
            !IsDetermined(frame_set, different[k], distances_px)))
      ++k;
    if (k < different.size()) {
      groups[k].others.push_back(std::move(frame_set.name));
      continue;
    }
    groups.push_back({frame_set.name, {}});
    different.push_back(std::move(frame_set));
  }
  groups.erase(std::remove_if(groups.begin(), groups.end(),
                              [](const auto& g) { return g.others.empty(); }),
               groups.end());
  // Sorts by name, independent of which image has the most features.
  for (NearDuplicates& group : groups)
    std::sort(group.others.begin(), group.others.end());
  std::sort(groups.begin(), groups.end(),
            [](const auto& a, const auto& b) { return a.image < b.image; });
  return groups;
}

std::vector<std::string> FindHeldOutDuplicates(
    const std::vector<Dataset>& cameras,
    const std::vector<std::string>& held_out,
    std::optional<double> duplicate_px) {
  if (AreAllImagesViews(duplicate_px)) return {};
  const std::vector<double> distances_px =
      ComputeDistancesPx(cameras, duplicate_px);
  const std::vector<FrameSet> frame_sets = SortFrames(cameras, held_out);
  std::vector<std::string> copies;
  for (const FrameSet& frame_set : frame_sets)
    if (frame_set.is_held_out &&
        std::any_of(frame_sets.begin(), frame_sets.end(),
                    [&](const FrameSet& other) {
                      return !other.is_held_out &&
                             IsDetermined(frame_set, other, distances_px);
                    }))
      copies.push_back(frame_set.name);
  std::sort(copies.begin(), copies.end());
  return copies;
}

std::vector<NearDuplicates> FilterGroups(
    const Dataset& dataset, const std::vector<NearDuplicates>& groups) {
  std::set<std::string> names;
  for (const ImageFeatures& image : dataset.images) names.insert(image.image);
  std::vector<NearDuplicates> own;
  for (const NearDuplicates& group : groups) {
    NearDuplicates part = {group.image, {}};
    for (const std::string& other : group.others)
      if (names.count(other) > 0) part.others.push_back(other);
    if (!part.others.empty()) own.push_back(std::move(part));
  }
  return own;
}

size_t CountDuplicates(const std::vector<NearDuplicates>& groups) {
  size_t count = 0;
  for (const NearDuplicates& group : groups) count += group.others.size();
  return count;
}

Dataset RemoveDuplicates(const Dataset& dataset,
                         const std::vector<NearDuplicates>& groups) {
  return KeepSelectedImages(dataset, groups, false);
}

Dataset SelectDuplicates(const Dataset& dataset,
                         const std::vector<NearDuplicates>& groups) {
  return KeepSelectedImages(dataset, groups, true);
}

}  // namespace raygrid
