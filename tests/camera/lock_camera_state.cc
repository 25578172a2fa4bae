/// Locks the state of a camera while it streams, and tells what frames say:
///   lock_camera_state v4l2:/dev/video0|libcamera:ID
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "camera_error.h"
#include "libcamera_source.h"
#include "v4l2_source.h"

namespace raygrid {
namespace {

constexpr int kNumFrames = 8;

void Tell(const char* name, const std::optional<float>& value) {
  if (value) std::printf(" %s=%g", name, double{*value});
}

// Returns whether all frames came.
bool TakeFrames(FrameSource* source, const char* when) {
  FrameInfo info = {};
  for (int i = 0; i < kNumFrames; ++i) {
    const auto frame = source->Next(std::chrono::seconds(20));
    if (!frame) return false;
    info = frame->info;
    source->Release(*frame);
  }
  std::printf("%s:", when);
  Tell("exposure_us", info.exposure_us);
  Tell("gain", info.analogue_gain);
  if (info.focus_steps) std::printf(" focus_steps=%d", *info.focus_steps);
  std::printf("\n");
  return true;
}

bool IsV4l2(const std::string& name) { return name.rfind("v4l2:", 0) == 0; }

std::unique_ptr<FrameSource> OpenCamera(const CameraList& cameras,
                                        const std::string& name) {
  const std::string id = name.substr(name.find(':') + 1);
  if (IsV4l2(name))
    return std::make_unique<V4l2Source>(OpenV4l2Device(id),
                                        V4l2Options{"", 640, 480, false, {}});
  return std::make_unique<LibcameraSource>(
      cameras.Find(id), LibcameraOptions{"", 640, 480, false, {}});
}

bool Run(const std::string& name) {
  const CameraList cameras;
  const auto source = OpenCamera(cameras, name);
  source->Start();
  if (!TakeFrames(source.get(), "before")) return false;
  const StateLock lock = source->LockState();
  for (const std::string& text : lock.locked)
    std::printf("locked: %s\n", text.c_str());
  for (const std::string& text : lock.open)
    std::printf("open: %s\n", text.c_str());
  const bool is_whole = TakeFrames(source.get(), "after");
  source->Stop();
  return is_whole;
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  if (argc != 2) return 1;
  try {
    return raygrid::Run(argv[1]) ? 0 : 2;
  } catch (const raygrid::CameraError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
