#include "v4l2_list.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "camera_error.h"
#include "v4l2_controls.h"
#include "v4l2_formats.h"
#include "v4l2_stream.h"

namespace raygrid {
namespace {

std::string Size(uint32_t width, uint32_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

// " 640x480 1280x720", or " 32x32 to 1920x1080 in steps of 2x2"
std::string DescribeSizes(V4l2Device* device, uint32_t code) {
  std::string text;
  v4l2_frmsizeenum size = {};
  size.pixel_format = code;
  for (; IoctlWithRetry(device, VIDIOC_ENUM_FRAMESIZES, &size) == 0;
       ++size.index) {
    if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE) {
      const v4l2_frmsize_stepwise& steps = size.stepwise;
      return " " + Size(steps.min_width, steps.min_height) + " to " +
             Size(steps.max_width, steps.max_height) + " in steps of " +
             Size(steps.step_width, steps.step_height);
    }
    text += " " + Size(size.discrete.width, size.discrete.height);
  }
  return text;
}

std::string DescribeFormats(V4l2Device* device, uint32_t buffer_type) {
  std::string text;
  v4l2_fmtdesc listed = {};
  listed.type = buffer_type;
  for (; IoctlWithRetry(device, VIDIOC_ENUM_FMT, &listed) == 0;
       ++listed.index) {
    text += "  " + V4l2FormatName(listed.pixelformat) +
            DescribeSizes(device, listed.pixelformat);
    if (!FindV4l2Format(listed.pixelformat) &&
        !IsJpegFormat(listed.pixelformat))
      text += " (not supported)";
    text += "\n";
  }
  return text;
}

// Opens the device with this path, if it captures frames.
std::unique_ptr<V4l2Device> OpenCamera(const std::string& path) {
  try {
    auto device = OpenV4l2Device(path);
    FindBufferType(device.get());
    return device;
  } catch (const CameraError&) {
    return nullptr;
  }
}

}  // namespace

std::vector<std::string> FindV4l2Devices() {
  constexpr char kStem[] = "/dev/video";
  constexpr size_t kStemLength = sizeof(kStem) - 1;
  std::vector<std::pair<int, std::string>> numbered;
  std::error_code ignored;
  for (const auto& entry :
       std::filesystem::directory_iterator("/dev", ignored)) {
    const std::string path = entry.path();
    if (path.compare(0, kStemLength, kStem) != 0) continue;
    if (OpenCamera(path))
      numbered.emplace_back(std::atoi(path.c_str() + kStemLength), path);
  }
  std::sort(numbered.begin(), numbered.end());
  std::vector<std::string> paths;
  for (const auto& [number, path] : numbered) paths.push_back(path);
  return paths;
}

std::string DescribeV4l2Device(V4l2Device* device) {
  v4l2_capability capability = {};
  IoctlWithRetry(device, VIDIOC_QUERYCAP, &capability);
  return "v4l2:" + device->path() + " (" +
         reinterpret_cast<const char*>(capability.card) + ", " +
         reinterpret_cast<const char*>(capability.bus_info) + ")\n" +
         DescribeFormats(device, FindBufferType(device)) +
         DescribeV4l2Controls(device);
}

std::string DescribeV4l2Devices() {
  std::string text;
  for (const std::string& path : FindV4l2Devices())
    if (const auto device = OpenCamera(path))
      text += DescribeV4l2Device(device.get());
  return text;
}

}  // namespace raygrid
