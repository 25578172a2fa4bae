#include "points.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <memory>

#include "camera_error.h"

namespace raygrid {
namespace {

constexpr double kLimit_px = 16384, kOne_q16 = 65536;

struct CloseFile {
  void operator()(std::FILE* file) const {
    if (file != stdin) std::fclose(file);
  }
};

using File = std::unique_ptr<std::FILE, CloseFile>;

File Open(const std::string& path) {
  File file(path == "-" ? stdin : std::fopen(path.c_str(), "r"));
  if (!file)
    throw CameraError(CameraExit::kInput,
                      path + ": cannot be read; check name and permissions");
  return file;
}

struct Point {
  double x, y;
  std::optional<double> condition;
};

// Parses a line of two numbers that can be pixel coordinates, and optionally a
// third number.
std::optional<Point> ParsePoint(const char* line) {
  Point point;
  double condition;
  int length = 0, whole_length = 0;
  const int num = std::sscanf(line, "%lf ,%lf %n,%lf %n", &point.x, &point.y,
                              &length, &condition, &whole_length);
  if (num == 3) {
    if (!std::isfinite(condition)) return std::nullopt;
    point.condition = condition;
    length = whole_length;
  }
  if (num < 2 || line[length] != 0 || !(std::abs(point.x) < kLimit_px) ||
      !(std::abs(point.y) < kLimit_px))
    return std::nullopt;
  return point;
}

bool Undistort(const rg_camera& camera, const std::optional<rg_mode>& mode,
               double x, double y, rg_pixel* undistorted) {
  rg_pixel pixel = {static_cast<int32_t>(std::lround(x * kOne_q16)),
                    static_cast<int32_t>(std::lround(y * kOne_q16))};
  if (mode && rg_mode_to_calibrated(&*mode, pixel, &pixel) != RG_OK)
    return false;
  return rg_undistort_point(&camera, pixel, undistorted) == RG_OK;
}

void WritePoint(std::FILE* output, double x, double y, bool is_seen,
                const rg_pixel& to) {
  std::fprintf(output, "%.10g,%.10g,", x, y);
  if (is_seen)
    std::fprintf(output, "%.5f,%.5f\n", to.x_q16 / kOne_q16,
                 to.y_q16 / kOne_q16);
  else
    std::fputs(",\n", output);
  if (std::fflush(output) != 0)
    throw CameraError(CameraExit::kOutput,
                      std::string("cannot write to standard output (") +
                          std::strerror(errno) + "); keep the reader running");
}

}  // namespace

void UndistortPoints(const rg_camera& camera,
                     const std::optional<rg_mode>& mode,
                     const std::string& path, std::FILE* output,
                     const std::function<bool()>& is_stopped,
                     OperatingPointFollower* stack) {
  const File file = Open(path);
  std::fputs("x,y,u,v\n", output);
  char line[256];
  for (uint64_t number = 1;
       !is_stopped() && std::fgets(line, sizeof(line), file.get()); ++number) {
    const std::optional<Point> point = ParsePoint(line);
    if (!point) {
      if (number == 1 || line[0] == '#' || line[0] == '\n') continue;
      throw CameraError(CameraExit::kInput,
                        path + ":" + std::to_string(number) +
                            ": expected x,y below 16384, optionally with a "
                            "third number, the lens position or temperature");
    }
    if (point->condition) {
      if (stack->is_idle())
        throw CameraError(
            CameraExit::kInput,
            path + ":" + std::to_string(number) +
                ": has a third number, but the blob was not calibrated over a "
                "range of focus or temperature; omit it");
      stack->FollowValue(*point->condition);
    }
    rg_pixel undistorted = {};
    const bool is_seen =
        Undistort(camera, mode, point->x, point->y, &undistorted);
    WritePoint(output, point->x, point->y, is_seen, undistorted);
  }
  if (std::ferror(file.get()) && !is_stopped())
    throw CameraError(CameraExit::kInput, path + ": cannot be read");
}

}  // namespace raygrid
