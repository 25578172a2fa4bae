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
                      path + ": cannot be read; check the name");
  return file;
}

// Whether a line is two numbers that can be pixels.
bool ParsePoint(const char* line, double* x, double* y) {
  int length = 0;
  return std::sscanf(line, "%lf ,%lf %n", x, y, &length) == 2 &&
         line[length] == 0 && std::abs(*x) < kLimit_px &&
         std::abs(*y) < kLimit_px;
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
                      std::string("standard output: cannot be written (") +
                          std::strerror(errno) + "); keep the reader running");
}

}  // namespace

void UndistortPoints(const rg_camera& camera,
                     const std::optional<rg_mode>& mode,
                     const std::string& path, std::FILE* output,
                     const std::function<bool()>& is_stopped) {
  const File file = Open(path);
  std::fputs("x,y,u,v\n", output);
  char line[256];
  for (uint64_t number = 1;
       !is_stopped() && std::fgets(line, sizeof(line), file.get()); ++number) {
    double x, y;
    if (!ParsePoint(line, &x, &y)) {
      if (number == 1 || line[0] == '#' || line[0] == '\n') continue;
      throw CameraError(CameraExit::kInput,
                        path + ":" + std::to_string(number) +
                            ": not two numbers x,y below 16384");
    }
    rg_pixel undistorted = {};
    const bool is_seen = Undistort(camera, mode, x, y, &undistorted);
    WritePoint(output, x, y, is_seen, undistorted);
  }
  if (std::ferror(file.get()) && !is_stopped())
    throw CameraError(CameraExit::kInput, path + ": cannot be read");
}

}  // namespace raygrid
