#include "camera_check.h"

#include <cstdio>

#include "camera_error.h"

namespace raygrid {
namespace {

std::string DescribeSize(const StreamFormat& format) {
  return std::to_string(format.width) + "x" + std::to_string(format.height);
}

// Returns the argument of raygrid pack --capture-settings that describes all
// metadata provided by the source.
std::string DescribeCapture(const FrameInfo& info) {
  char text[160] = "";
  std::string words;
  const auto add = [&] {
    words += (words.empty() ? "" : ",") + std::string(text);
  };
  if (info.crop) {
    std::snprintf(text, sizeof(text), "crop=%d,%d,%u,%u", info.crop->x,
                  info.crop->y, info.crop->width, info.crop->height);
    add();
  }
  if (info.lens_position) {
    std::snprintf(text, sizeof(text), "lens=%.6g", double{*info.lens_position});
    add();
  }
  if (info.zoom) {
    std::snprintf(text, sizeof(text), "zoom=%.6g", *info.zoom);
    add();
  }
  if (info.orientation) {
    std::snprintf(text, sizeof(text), "orientation=%d", *info.orientation);
    add();
  }
  if (info.sensor_temperature_c) {
    std::snprintf(text, sizeof(text), "temperature=%.4g",
                  double{*info.sensor_temperature_c});
    add();
  }
  if (info.exposure_us) {
    std::snprintf(text, sizeof(text), "exposure=%.6g",
                  double{*info.exposure_us});
    add();
  }
  if (info.analogue_gain) {
    std::snprintf(text, sizeof(text), "gain=%.4g", double{*info.analogue_gain});
    add();
  }
  return words.empty() ? "" : "; capture settings: " + words;
}

std::string DescribeSource(const CameraArguments& arguments) {
  if (arguments.recording == "-") return "standard input";
  if (!arguments.recording.empty()) return arguments.recording;
  if (!arguments.camera.empty()) return "camera " + arguments.camera;
  return "the only camera";
}

}  // namespace

CameraArguments MakeCheckArguments(CameraArguments arguments) {
  arguments.output.clear();
  arguments.http.port = 0;
  arguments.num_frames = 1;
  arguments.is_quiet = true;
  return arguments;
}

std::string DescribeCheck(const CameraArguments& arguments,
                          const FrameSource& source,
                          const Undistorter& undistorter) {
  const UndistorterStatistics statistics = undistorter.statistics();
  if (statistics.undistorted == 0) FailCheck();
  char time[32];
  std::snprintf(time, sizeof(time), "%.2f", statistics.remap.Quantile_ms(0.5));
  const std::string memory = source.memory();
  return arguments.blob + ": undistorts " + DescribeSize(source.format()) +
         " " + source.format().pixel_format->name + " of " +
         DescribeSource(arguments) + " to " +
         DescribeSize(undistorter.format()) + " in " + time + " ms" +
         (memory.empty() ? "" : "; frame buffers: " + memory) +
         DescribeCapture(statistics.last_info) + "\n";
}

void FailCheck() {
  throw CameraError(CameraExit::kInput,
                    "--check: interrupted before a frame was received; check "
                    "that the source delivers frames");
}

}  // namespace raygrid
