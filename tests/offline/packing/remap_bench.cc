// Times undistortion against cv::remap with fixed-point maps of the same
// positions, one thread, and compares images with exact bilinear
// interpolation. Run by hand:
//   remap_bench [--write FOLDER] [WIDTH...]
//     WIDTH     of 640, 1280, 1920, 3840; all without any
//     --write   also writes maps and frames of the last width, for the timing
//     of
//               another OpenCV (tools/measure/remap_rival.py)
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "camera/opencv.h"
#include "camera/thin_prism_fisheye.h"
#include "cortex_m/tile_corners.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "frames/component_map.h"
#include "frames/pixel_formats.h"
#include "kernels/kernel_list.h"
#include "packing/remap_fitting.h"
#include "packing/view_request.h"
#include "raygrid.h"

namespace raygrid {
namespace {

constexpr ImageSize kSizes[] = {
    {640, 480}, {1280, 800}, {1920, 1080}, {3840, 2160}};

// A camera and the view that its frames are rectified to.
struct BenchedCamera {
  std::string name;
  std::unique_ptr<CameraModel> camera;
  double hfov_deg;
};

std::vector<BenchedCamera> MakeViews(const ImageSize& size) {
  const double w = size.width;
  const double cx = (w - 1) / 2 + 0.004 * w;
  const double cy = (size.height - 1) / 2.0 - 0.003 * size.height;
  const OpenCvModel::ParameterArray mild = {
      0.7 * w, 0.7 * w, cx, cy, -0.3, 0.1, 0, 0, 0, 0, 7e-4, -4e-4};
  const ThinPrismFisheye::ParameterArray fisheye = {
      0.36 * w, 0.36 * w, cx, cy, -0.012, 0.008, -0.006, 0.001, 0, 0, 0, 0};
  const Area area = WholeImage(size);
  std::vector<BenchedCamera> views;
  views.push_back(
      {"mild", std::make_unique<OpenCvModel>(size, area, mild), 71});
  for (const double hfov_deg : {108.0, 132.0})
    views.push_back({hfov_deg == 108 ? "fisheye to 108" : "fisheye to 132",
                     std::make_unique<ThinPrismFisheye>(size, area, fisheye),
                     hfov_deg});
  return views;
}

// CPU time of this thread alone, so that other load does not count.
double Now() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return time.tv_sec + time.tv_nsec * 1e-9;
}

// Medians of works run in turn, so that all suffer alike from other load. Each
// runs twice, and the second time counts: its frames are then in the cache as
// far as they fit.
std::vector<double> MedianSeconds(
    const std::vector<std::function<void()>>& works) {
  std::vector<std::vector<double>> times(works.size());
  const double begin = Now();
  for (int run = -1; run < 7 || (Now() - begin < 0.4 && run < 400); ++run) {
    for (size_t k = 0; k < works.size(); ++k) {
      works[k]();
      const double start = Now();
      works[k]();
      if (run >= 0) times[k].push_back(Now() - start);
    }
  }
  std::vector<double> medians;
  for (std::vector<double>& t : times) {
    std::nth_element(t.begin(), t.begin() + t.size() / 2, t.end());
    medians.push_back(t[t.size() / 2]);
  }
  return medians;
}

// The largest blocks that keep a bound, which coarse images make wider.
RemapTable FitTable(const BenchedCamera& view, const VirtualView& target) {
  for (double bound_px = 0.05;; bound_px *= 2) {
    try {
      return FitRemapTable(*view.camera, target, bound_px, 1);
    } catch (const Error& error) {
      if (bound_px > 1) throw;
    }
  }
}

// The source positions of a lattice's pixels, as the runtime has them; far
// outside where they have no source.
cv::Mat2f Positions(const uint8_t* section, const rg_component& lattice,
                    const ImageSize& output) {
  const rg_range range_x = rg_source_range(section, &lattice, 0);
  const rg_range range_y = rg_source_range(section, &lattice, 1);
  const int width = output.width >> lattice.log2[0];
  const int height = output.height >> lattice.log2[1];
  cv::Mat2f positions(height, width);
  const uint32_t part_log2[2] = {rg_tile_log2(section, &lattice, 0),
                                 rg_tile_log2(section, &lattice, 1)};
  const int log2_x = part_log2[0] - lattice.log2[0];
  const int log2_y = part_log2[1] - lattice.log2[1];
  for (int y = 0; y < height; ++y) {
    rg_tile_row parts;
    rg_init_tile_row(section, part_log2[0], part_log2[1], y >> log2_y, &parts);
    rg_block_row row;
    for (int x = 0; x < width; ++x) {
      const int in_block = x & ((1 << log2_x) - 1);
      if (in_block == 0) {
        rg_block block;
        rg_next_block(&parts, &block);
        rg_transform_block(&lattice, &block);
        rg_compute_block_row(&block, y & ((1 << log2_y) - 1), &row);
      }
      const rg_position p = rg_row_position(&row, in_block);
      const bool valid =
          !parts.is_block_empty &&
          rg_clamp(p.q12[0], range_x.min_q12, range_x.max_q12) == p.q12[0] &&
          rg_clamp(p.q12[1], range_y.min_q12, range_y.max_q12) == p.q12[1];
      positions(y, x) = valid ? cv::Vec2f(p.q12[0] / 4096.f, p.q12[1] / 4096.f)
                              : cv::Vec2f(-1000, -1000);
    }
  }
  return positions;
}

// Writes pixels without a header; not if folder is empty.
void WriteRaw(const std::string& folder, const std::string& name,
              const cv::Mat& mat) {
  if (folder.empty()) return;
  WriteFile(folder + "/" + name,
            std::string(reinterpret_cast<const char*>(mat.data),
                        mat.total() * mat.elemSize()));
}

struct FixedMap {
  cv::Mat pixels, weights, nearest;
};

FixedMap MakeFixedMap(const cv::Mat2f& positions) {
  FixedMap map;
  cv::Mat none;
  cv::convertMaps(positions, cv::Mat(), map.pixels, map.weights, CV_16SC2,
                  false);
  cv::convertMaps(positions, cv::Mat(), map.nearest, none, CV_16SC2, true);
  return map;
}

// Waves and noise.
cv::Mat MakeImage(int rows, int columns, int type) {
  cv::Mat image(rows, columns, type);
  std::minstd_rand random(1);
  for (int y = 0; y < rows; ++y) {
    uint8_t* row = image.ptr(y);
    for (int x = 0; x < columns * image.channels(); ++x)
      row[x] = static_cast<uint8_t>(128 + 60 * std::sin(x * 0.13) +
                                    50 * std::cos(y * 0.11 + x * 0.05) +
                                    static_cast<int>(random() % 17) - 8);
  }
  return image;
}

// Against bilinear interpolation in double precision at the same positions.
void PrintImageError(const cv::Mat2f& positions, const cv::Mat& source,
                     const cv::Mat& result) {
  double sum = 0, worst = 0;
  long count = 0;
  for (int y = 0; y < positions.rows; ++y) {
    for (int x = 0; x < positions.cols; ++x) {
      const double px = positions(y, x)[0], py = positions(y, x)[1];
      const int c = static_cast<int>(px), r = static_cast<int>(py);
      if (px < 0 || py < 0 || c + 1 >= source.cols || r + 1 >= source.rows)
        continue;
      const double u = px - c, v = py - r;
      const uint8_t* p = source.ptr(r) + c;
      const uint8_t* q = source.ptr(r + 1) + c;
      const double exact = (p[0] * (1 - u) + p[1] * u) * (1 - v) +
                           (q[0] * (1 - u) + q[1] * u) * v;
      const double error = std::abs(exact - result.at<uint8_t>(y, x));
      sum += error * error;
      worst = std::max(worst, error);
      ++count;
    }
  }
  std::printf("  image error: rms %.3f, max %.2f grey levels\n",
              std::sqrt(sum / count), worst);
}

// Logarithms of ratios by lens, work and kernels.
using Ratios = std::map<std::string, std::vector<double>>;

struct Bench {
  const BenchedCamera& view;
  ImageSize size;
  rg_camera camera;
  Ratios* ratios;

  // Times the frames of one format against OpenCV's work.
  void Run(const char* what, const rg_image& image, rg_target target,
           const std::function<void()>& opencv) const {
    std::vector<std::string> names = {"cv::remap"};
    std::vector<std::function<void()>> works = {opencv};
    std::vector<rg_target> targets;
#define RG_KERNEL(name, parts, abilities, runs) , #name
    for (const char* name : {"portable" RG_KERNELS}) {
#undef RG_KERNEL
      target.kernels = rg_find_kernels(name);
      if (!target.kernels) continue;
      names.push_back(name);
      targets.push_back(target);
    }
    for (const rg_target& t : targets)
      works.push_back([this, &image, &t] {
        if (rg_remap(&camera, &image, &t) != RG_OK) std::abort();
      });
    const std::vector<double> seconds = MedianSeconds(works);
    const double megapixels = size.width * size.height / 1e6;
    std::printf("  %-12s", what);
    for (size_t k = 0; k < names.size(); ++k) {
      std::printf(" %s %.0f", names[k].c_str(), megapixels / seconds[k]);
      if (k == 0) continue;
      std::printf(" (%.2f)", seconds[0] / seconds[k]);
      (*ratios)[view.name + ", " + what + ", " + names[k]].push_back(
          std::log(seconds[0] / seconds[k]));
    }
    std::printf(" Mpx/s\n");
  }
};

void SetPlane(int plane, const cv::Mat& source, cv::Mat* output,
              rg_image* image, rg_target* target) {
  image->planes[plane].data = source.data;
  image->planes[plane].stride = static_cast<uint32_t>(source.step);
  target->planes[plane].data = output->data;
  target->planes[plane].stride = static_cast<uint32_t>(output->step);
}

void RunView(const BenchedCamera& view, const ImageSize& size,
             const std::string& folder, Ratios* ratios) {
  ViewRequest request;
  request.size = size;
  request.hfov_deg = view.hfov_deg;
  const VirtualView target_camera = MakeView(*view.camera, request);
  double begin = Now();
  const RemapTable table = FitTable(view, target_camera);
  const double fit_seconds = Now() - begin;
  rg_remap_section fields = table.section;
  fields.empty_blocks = table.empty_blocks.data();
  fields.bends = table.bends.data();
  std::vector<uint32_t> words(rg_remap_section_size(&fields) / 4);
  auto* section = reinterpret_cast<uint8_t*>(words.data());
  rg_write_remap(&fields, table.residuals.data(), section);
  std::printf(
      "%s, %d x %d: blocks of %d, parts of %d, %.4f bytes/px, error %.4f px, "
      "built in %.0f ms\n",
      view.name.c_str(), size.width, size.height, 1 << fields.block_log2,
      1 << (fields.part_log2 != 0 ? fields.part_log2 : fields.block_log2),
      4.0 * words.size() / size.width / size.height, table.max_error_px,
      fit_seconds * 1e3);

  Bench bench = {view, size, {}, ratios};
  bench.camera.frame_width = static_cast<uint16_t>(size.width);
  bench.camera.frame_height = static_cast<uint16_t>(size.height);
  bench.camera.remap = section;

  rg_component lattices[2];
  for (uint32_t k = 0; k < 2; ++k)
    rg_get_component(RG_FORMAT_NV12, k, &lattices[k]);
  const cv::Mat2f luma_positions = Positions(section, lattices[0], size);
  const FixedMap luma = MakeFixedMap(luma_positions);
  const cv::Mat2f chroma_positions = Positions(section, lattices[1], size);
  const FixedMap chroma = MakeFixedMap(chroma_positions);
  const cv::Mat grey = MakeImage(size.height, size.width, CV_8UC1);
  const cv::Mat pairs = MakeImage(size.height / 2, size.width / 2, CV_8UC2);
  const cv::Mat rgb = MakeImage(size.height, size.width, CV_8UC3);
  cv::Mat grey_out = grey.clone(), pairs_out = pairs.clone(),
          rgb_out = rgb.clone();
  cv::Mat grey_cv, pairs_cv, rgb_cv;
  WriteRaw(folder, view.name + ".luma.positions", luma_positions);
  WriteRaw(folder, view.name + ".chroma.positions", chroma_positions);
  WriteRaw(folder, "grey", grey);
  WriteRaw(folder, "pairs", pairs);
  WriteRaw(folder, "rgb", rgb);

  rg_image image = {};
  rg_target target = {};
  image.width = bench.camera.frame_width;
  image.height = bench.camera.frame_height;
  target.num_rows = image.height;

  image.format = RG_FORMAT_GREY8;
  SetPlane(0, grey, &grey_out, &image, &target);
  bench.Run("GREY", image, target, [&] {
    cv::remap(grey, grey_cv, luma.pixels, luma.weights, cv::INTER_LINEAR);
  });
  PrintImageError(luma_positions, grey, grey_out);
  target.sampling = RG_SAMPLING_NEAREST;
  bench.Run("GREY nearest", image, target, [&] {
    cv::remap(grey, grey_cv, luma.nearest, cv::Mat(), cv::INTER_NEAREST);
  });
  target.sampling = RG_SAMPLING_BILINEAR;

  image.format = RG_FORMAT_NV12;
  SetPlane(1, pairs, &pairs_out, &image, &target);
  bench.Run("NV12", image, target, [&] {
    cv::remap(grey, grey_cv, luma.pixels, luma.weights, cv::INTER_LINEAR);
    cv::remap(pairs, pairs_cv, chroma.pixels, chroma.weights, cv::INTER_LINEAR);
  });

  image.format = RG_FORMAT_RGB24;
  SetPlane(0, rgb, &rgb_out, &image, &target);
  bench.Run("RGB24", image, target, [&] {
    cv::remap(rgb, rgb_cv, luma.pixels, luma.weights, cv::INTER_LINEAR);
  });
  std::fflush(stdout);
}

// The list of the folder's contents, for the other program.
void WriteSummary(const std::string& folder, const ImageSize& size,
                  const std::vector<BenchedCamera>& views) {
  nlohmann::json json = {
      {"opencv", CV_VERSION}, {"columns", size.width}, {"rows", size.height}};
  for (const BenchedCamera& view : views) json["views"].push_back(view.name);
  if (!folder.empty()) WriteFile(folder + "/views.json", json.dump(1) + "\n");
}

int Main(std::vector<std::string> arguments) {
  cv::setNumThreads(1);
  std::string folder;
  if (arguments.size() >= 2 && arguments[0] == "--write") {
    folder = arguments[1];
    arguments.erase(arguments.begin(), arguments.begin() + 2);
  }
  Ratios ratios;
  for (const ImageSize& size : kSizes) {
    const std::string width = std::to_string(size.width);
    if (!arguments.empty() &&
        std::count(arguments.begin(), arguments.end(), width) == 0)
      continue;
    const std::vector<BenchedCamera> views = MakeViews(size);
    for (const BenchedCamera& view : views)
      RunView(view, size, folder, &ratios);
    WriteSummary(folder, size, views);
  }
  std::printf("\nTimes faster than cv::remap, geometric means:\n");
  for (const auto& [name, logs] : ratios) {
    double sum = 0;
    for (const double log : logs) sum += log;
    std::printf("  %-36s %.2f\n", name.c_str(), std::exp(sum / logs.size()));
  }
  return 0;
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  return raygrid::Main(std::vector<std::string>(argv + 1, argv + argc));
}
