/// A source of grey frames from a device that tests play.
#ifndef RAYGRID_TESTS_CAMERA_FAKE_V4L2_SOURCE_H
#define RAYGRID_TESTS_CAMERA_FAKE_V4L2_SOURCE_H

#include <chrono>
#include <memory>

#include "fake_v4l2_device.h"
#include "v4l2_source.h"

namespace raygrid {

using Event = FakeV4l2State::Event;

constexpr uint32_t kWidth = 64, kHeight = 48, kStride = 80;
constexpr std::chrono::milliseconds kSoon(2000), kNow(0);

// Grey frames whose rows have gaps.
inline void MakeGrey(FakeV4l2State* state) {
  state->formats = {
      {V4L2_PIX_FMT_GREY, kWidth, kHeight, {kStride}, {kStride * kHeight}}};
}

inline std::unique_ptr<V4l2Source> Open(FakeV4l2State* state,
                                        const V4l2Options& options = {
                                            "", kWidth, kHeight, true, {}}) {
  return std::make_unique<V4l2Source>(std::make_unique<FakeV4l2Device>(state),
                                      options);
}

inline Event Frame(uint8_t value, uint32_t sequence = 0) {
  Event event;
  event.value = value;
  event.sequence = sequence;
  return event;
}

inline Event Failure(int error) {
  Event event;
  event.error = error;
  return event;
}

// The value of the next frame's pixels, the last one among them; -1 for none.
inline int NextValue(V4l2Source* source) {
  const auto frame = source->Next(kSoon);
  if (!frame) return -1;
  const int plane = source->format().num_planes - 1;
  const int value = frame->image.planes[plane]
                        .data[source->format().planes[plane].extent() - 1];
  source->Release(*frame);
  return value;
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_CAMERA_FAKE_V4L2_SOURCE_H
