#include "exchange/maps_format.h"

#include <fmt/format.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "exchange/npz.h"
#include "exchange/pixel_origin.h"

namespace raygrid {
namespace {

constexpr char kFixed[] = "fixed", kNpz[] = ".npz";

// The two remap tables, with the camera matrix and image size that users need
// with them.
struct OpenCvMaps {
  cv::Mat map1, map2, matrix, source_size;
};

// Returns the source coordinates x and y; -1 for pixels whose source is outside
// the image, where OpenCV fills in the border.
std::pair<cv::Mat, cv::Mat> FloatMaps(const ViewTable& view) {
  std::pair<cv::Mat, cv::Mat> maps(
      cv::Mat(view.size.height, view.size.width, CV_32FC1),
      cv::Mat(view.size.height, view.size.width, CV_32FC1));
  for (int y = 0; y < view.size.height; ++y)
    for (int x = 0; x < view.size.width; ++x) {
      const auto& source = view.At(x, y);
      const Eigen::Vector2d at =
          source ? ToProgram(PixelOrigin::kFirstPixelCenter, {}, *source)
                 : Eigen::Vector2d(-1, -1);
      maps.first.at<float>(y, x) = static_cast<float>(at.x());
      maps.second.at<float>(y, x) = static_cast<float>(at.y());
    }
  return maps;
}

OpenCvMaps MakeMaps(const ViewTable& view) {
  OpenCvMaps maps;
  auto [x, y] = FloatMaps(view);
  if (view.model == kFixed) {
    cv::convertMaps(x, y, maps.map1, maps.map2, CV_16SC2);
  } else {
    maps.map1 = x;
    maps.map2 = y;
  }
  if (view.matrix) cv::eigen2cv(*view.matrix, maps.matrix);
  maps.source_size =
      (cv::Mat_<int>(1, 2) << view.source_size.width, view.source_size.height);
  return maps;
}

NpyArray MakeArray(const std::string& name, const cv::Mat& matrix) {
  std::vector<size_t> shape = {static_cast<size_t>(matrix.rows),
                               static_cast<size_t>(matrix.cols)};
  if (matrix.channels() > 1) shape.push_back(matrix.channels());
  switch (matrix.depth()) {
    case CV_32F:
      return MakeNpyArray(name, shape, matrix.ptr<float>());
    case CV_16S:
      return MakeNpyArray(name, shape, matrix.ptr<int16_t>());
    case CV_16U:
      return MakeNpyArray(name, shape, matrix.ptr<uint16_t>());
    case CV_32S:
      return MakeNpyArray(name, {shape[1]}, matrix.ptr<int32_t>());
    default:
      return MakeNpyArray(name, shape, matrix.ptr<double>());
  }
}

std::string FormatNpz(const OpenCvMaps& maps) {
  std::vector<NpyArray> arrays = {MakeArray("map1", maps.map1),
                                  MakeArray("map2", maps.map2),
                                  MakeArray("source_size", maps.source_size)};
  if (!maps.matrix.empty()) arrays.push_back(MakeArray("K", maps.matrix));
  return WriteNpz(arrays);
}

std::string FormatStorage(const std::string& ending, const OpenCvMaps& maps) {
  cv::FileStorage storage(ending,
                          cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  storage << "map1" << maps.map1 << "map2" << maps.map2 << "source_size"
          << maps.source_size;
  if (!maps.matrix.empty()) storage << "K" << maps.matrix;
  return storage.releaseAndGetString();
}

TableOutput WriteMaps(const ViewTable& view) {
  const std::string ending =
      std::filesystem::path(view.path).extension().string();
  const OpenCvMaps maps = MakeMaps(view);
  const std::string text =
      ending == kNpz ? FormatNpz(maps) : FormatStorage(ending, maps);
  return {{{view.path, text}},
          fmt::format("map1 and map2, {}", view.model == kFixed
                                               ? "CV_16SC2 and CV_16UC1"
                                               : "CV_32FC1 each")};
}

}  // namespace

TableFormat MakeMapsFormat() {
  TableFormat format;
  format.name = "maps";
  format.holds =
      "OpenCV and numpy: map1 and map2 for cv2.remap(), as .npz, .yaml, .xml "
      "or .json (--inverse: inverse remap)";
  format.endings = {kNpz, ".yaml", ".yml", ".xml", ".json"};
  format.options = {"model", "rectified", "inverse"};
  format.models = {"float", kFixed};
  format.write_view = WriteMaps;
  return format;
}

}  // namespace raygrid
