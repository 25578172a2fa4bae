#include "capture_description.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture/board_outline.h"
#include "capture/board_view.h"
#include "capture/view_hint.h"

namespace raygrid {
namespace {

// Returns the outline of a board, and separately the edge along its first row.
ViewState ShowView(const CameraModel& camera, const Board& board,
                   const Pose& camera_from_board) {
  ViewState shown;
  shown.outline = ProjectOutline(camera, board, camera_from_board);
  if (!shown.outline.empty())
    shown.top.assign(shown.outline.begin(),
                     shown.outline.begin() + kOutlineSteps + 1);
  return shown;
}

}  // namespace

void DescribeFrame(const AssessedFrame& assessed, CaptureState* state) {
  state->word = assessed.word;
  state->hint = assessed.hint;
  state->width = assessed.frame->grey.size.width;
  state->height = assessed.frame->grey.size.height;
  state->features.clear();
  for (const Feature& feature : assessed.seen.features.features)
    state->features.push_back(feature.pixel);
  state->sharpness_px = assessed.seen.quality.max_spread_px;
  state->brightness = assessed.seen.quality.white / 255;
}

void DescribeKnown(const RigGuide& rig, size_t camera, CaptureState* state) {
  const CaptureGuide& guide = *rig.guide(camera);
  state->places.clear();
  state->stddev_px = 0;
  state->stddev_is_floor = guide.is_floor();
  if (const CameraInformation* const information = guide.information()) {
    state->stddev_px = information->Percentile95Px();
    for (const UncertaintySample& place : information->places())
      state->places.push_back({place.pixel, place.stddev_px});
  }
  state->is_done = rig.is_done();
  state->num_expected = rig.num_expected().value_or(-1);
}

void DescribeNext(const RigGuide& rig, const ImageFeatures& features,
                  CaptureState* state) {
  state->next.clear();
  state->arrow.clear();
  if (rig.is_done()) {
    state->hint = "done";
    return;
  }
  if (!rig.next()) return;
  const GuidedView& next = rig.next()->view;
  const CaptureGuide& guide = *rig.guide(rig.next()->camera);
  const CameraModel& camera = guide.camera();
  state->next.push_back(ShowView(camera, *next.board, next.camera_from_board));
  for (const LocatedBoard& located : guide.Locate(features)) {
    if (located.board->id != next.board->id) continue;
    const Eigen::Vector3d center = ComputeBoardCenter(*located.board);
    const auto from = camera.Project(located.camera_from_board * center);
    const auto to = camera.Project(next.camera_from_board * center);
    if (from && to) state->arrow = {*from, *to};
    if (state->hint.empty())
      state->hint = DescribeMove(camera, *next.board, located.camera_from_board,
                                 next.camera_from_board);
  }
  if (state->hint.empty()) state->hint = "move the board into the outline";
}

void DescribeRig(const RigGuide& rig, const PairedFrames& frames,
                 const AssessedFrames& assessed, size_t shown,
                 CaptureState* state) {
  state->cameras.resize(assessed.size());
  for (size_t c = 0; c < assessed.size(); ++c) {
    CameraState& camera = state->cameras[c];
    camera.name = frames.name(c);
    if (assessed[c].frame) camera.word = assessed[c].word;
    const CaptureGuide* const own = rig.guide(c);
    camera.stddev_px =
        own && own->information() ? own->information()->Percentile95Px() : 0;
    if (camera.word == "kept") state->word = "kept";
  }
  if (rig.next() && !state->hint.empty() && assessed[shown].frame)
    state->hint = state->camera + ": " + state->hint;
  state->links.clear();
  for (const RigGuide::Link& link : rig.links())
    state->links.push_back(
        {frames.name(link.first), frames.name(link.second), link.link.RmsPx()});
  if (const auto& pair = rig.to_connect()) {
    const std::string& first = frames.name(pair->first);
    const std::string& second = frames.name(pair->second);
    if (!rig.next())
      state->hint = fmt::format("show the board to {} and {} simultaneously",
                                first, second);
    state->warnings.push_back(
        fmt::format("no common view of {} and {} yet", first, second));
  }
  if (frames.is_unpaired())
    state->warnings.push_back(
        "the cameras' timestamps differ by more than --pair-within-ms");
}

}  // namespace raygrid
