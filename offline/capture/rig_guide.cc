#include "capture/rig_guide.h"

#include <algorithm>
#include <numeric>

#include "capture/view_hint.h"

namespace raygrid {
namespace {

// Union-find structure of cameras connected by links.
class ConnectedCameras {
 public:
  explicit ConnectedCameras(size_t count) : set_(count) {
    std::iota(set_.begin(), set_.end(), 0);
  }
  bool AreConnected(size_t a, size_t b) const { return set_[a] == set_[b]; }
  void Connect(size_t a, size_t b) {
    const size_t from = set_[a], to = set_[b];
    std::replace(set_.begin(), set_.end(), from, to);
  }

 private:
  std::vector<size_t> set_;
};

const LocatedBoard* FindBoard(const std::vector<LocatedBoard>& located,
                              int id) {
  const auto found = std::find_if(
      located.begin(), located.end(),
      [id](const LocatedBoard& board) { return board.board->id == id; });
  return found == located.end() ? nullptr : &*found;
}

}  // namespace

RigGuide::RigGuide(const std::vector<GuidedCamera>& cameras,
                   const Pattern& pattern, const GuideOptions& options)
    : cameras_(cameras),
      pattern_(std::make_shared<Pattern>(pattern)),
      options_(options) {
  UpdateLinks();
  ChooseLinkViews();
  ChooseNext();
  for (GuidedCamera& camera : cameras_) camera.live = nullptr;
}

bool RigGuide::IsCalibrated(size_t camera) const {
  return guide(camera) && guide(camera)->information();
}

// Builds the minimum-variance spanning tree of links (Kruskal's algorithm).
void RigGuide::UpdateLinks() {
  std::vector<Link> all;
  for (size_t a = 0; a < num_cameras(); ++a)
    for (size_t b = a + 1; b < num_cameras(); ++b)
      if (IsCalibrated(a) && IsCalibrated(b))
        if (auto link = CameraLink::Of(*cameras_[a].live, *cameras_[b].live))
          all.push_back({a, b, std::move(*link), std::nullopt});
  std::stable_sort(all.begin(), all.end(), [](const Link& a, const Link& b) {
    return a.link.RmsPx() < b.link.RmsPx();
  });
  ConnectedCameras connected(num_cameras());
  for (Link& link : all) {
    if (connected.AreConnected(link.first, link.second)) continue;
    connected.Connect(link.first, link.second);
    links_.push_back(std::move(link));
  }
  for (size_t c = 0; c < num_cameras(); ++c)
    if (!IsCalibrated(c)) return;
  for (size_t c = 1; c < num_cameras() && !to_connect_; ++c)
    if (!connected.AreConnected(0, c)) to_connect_ = {0, c};
}

void RigGuide::ChooseLinkViews() {
  for (Link& link : links_) {
    if (options_.target_px > 0 && link.link.RmsPx() <= options_.target_px)
      continue;
    for (const Board& board : pattern_->boards) {
      const auto view = FindBestNextView(
          guide(link.first)->camera(), board,
          [&](const Pose& pose) {
            return link.link.PredictViewGain(board, pose);
          },
          cameras_[link.first].avoided);
      if (view && view->gain >= options_.min_gain &&
          (!link.next || view->gain > link.next->gain))
        link.next = GuidedView{&board, view->camera_from_board, view->gain};
    }
  }
}

std::optional<Pose> RigGuide::ComputeRelativePose(size_t to,
                                                  size_t from) const {
  if (to == from) return Pose();
  // Links form a tree, so each camera is visited only once.
  std::vector<std::optional<Pose>> from_start(num_cameras());
  from_start[from] = Pose();
  for (size_t step = 0; step < links_.size(); ++step)
    for (const Link& link : links_) {
      auto& first = from_start[link.first];
      auto& second = from_start[link.second];
      const Pose& second_from_first = link.link.second_from_first();
      if (first && !second) second = second_from_first * *first;
      if (second && !first) first = second_from_first.Inverse() * *second;
    }
  return from_start[to];
}

double RigGuide::ComputeTotalGain(size_t camera, const Board& board,
                                  const Pose& camera_from_board) const {
  double total = 0;
  for (size_t c = 0; c < num_cameras(); ++c) {
    const auto pose = ComputeRelativePose(c, camera);
    if (!pose || !IsCalibrated(c) || guide(c)->is_done()) continue;
    total += guide(c)->information()->PredictViewGain(
        board, *pose * camera_from_board);
  }
  for (const Link& link : links_)
    if (const auto pose = ComputeRelativePose(link.first, camera);
        pose && link.next)
      total += link.link.PredictViewGain(board, *pose * camera_from_board);
  return total;
}

void RigGuide::ChooseNext() {
  for (size_t c = 0; c < num_cameras(); ++c) {
    if (!guide(c) || IsCalibrated(c) || !guide(c)->next()) continue;
    next_ = RigView{c, *guide(c)->next()};
    return;
  }
  if (to_connect_ && !options_.skip_connecting_views) return;
  std::vector<RigView> candidates;
  for (size_t c = 0; c < num_cameras(); ++c)
    if (guide(c) && guide(c)->next())
      candidates.push_back({c, *guide(c)->next()});
  for (const Link& link : links_)
    if (link.next) candidates.push_back({link.first, *link.next});
  double most = 0;
  for (const RigView& candidate : candidates) {
    const double gain =
        ComputeTotalGain(candidate.camera, *candidate.view.board,
                         candidate.view.camera_from_board);
    if (next_ && gain <= most) continue;
    most = gain;
    next_ = candidate;
  }
  is_done_ = candidates.empty() && !to_connect_ &&
             std::all_of(cameras_.begin(), cameras_.end(),
                         [](const GuidedCamera& camera) {
                           return camera.guide && camera.guide->is_done();
                         });
}

std::optional<int> RigGuide::num_expected() const {
  std::optional<int> most = 0;
  for (const GuidedCamera& camera : cameras_) {
    const auto expected =
        camera.guide ? camera.guide->num_expected() : std::nullopt;
    if (!expected) return std::nullopt;
    most = std::max(most, expected);
  }
  if (is_done_) return 0;
  return std::max(most, std::optional(1));
}

bool RigGuide::IsInformativeForLink(
    const Link* link, size_t first, size_t second,
    const std::vector<const ImageFeatures*>& images) const {
  const ImageFeatures &in_first = *images[first], &in_second = *images[second];
  // Views that are redundant for both cameras would only reduce noise.
  if (guide(first)->ComputeGain(in_first) <= 0 &&
      guide(second)->ComputeGain(in_second) <= 0)
    return false;
  const std::vector<LocatedBoard> seen = guide(second)->Locate(in_second);
  double left = 1;  // remaining fraction of the link's variance
  bool is_shared = false, is_next = false;
  for (const LocatedBoard& board : guide(first)->Locate(in_first)) {
    const LocatedBoard* const other = FindBoard(seen, board.board->id);
    if (!other) continue;
    is_shared = true;
    if (!link) continue;
    left *= 1 - link->link.ComputeGain({board.camera_from_board,
                                        other->camera_from_board,
                                        MakeMatches(*board.board, in_first),
                                        MakeMatches(*board.board, in_second)});
    is_next |=
        link->next && link->next->board->id == board.board->id &&
        HasReachedView(guide(first)->camera(), *board.board,
                       board.camera_from_board, link->next->camera_from_board);
  }
  if (!link) return is_shared;
  if (!link->next) return false;
  const double wanted =
      is_next ? 0 : options_.min_gain_ratio * link->next->gain;
  return 1 - left >= std::max(options_.min_gain, wanted);
}

bool RigGuide::IsInformativeForLinks(
    const std::vector<const ImageFeatures*>& images) const {
  const auto is_usable = [&](size_t c) { return images[c] && IsCalibrated(c); };
  for (const Link& link : links_)
    if (is_usable(link.first) && is_usable(link.second) &&
        IsInformativeForLink(&link, link.first, link.second, images))
      return true;
  if (!to_connect_) return false;
  for (size_t a = 0; a < num_cameras(); ++a)
    for (size_t b = a + 1; b < num_cameras(); ++b)
      if (is_usable(a) && is_usable(b) && !ComputeRelativePose(b, a) &&
          IsInformativeForLink(nullptr, a, b, images))
        return true;
  return false;
}

}  // namespace raygrid
