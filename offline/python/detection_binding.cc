#include <fmt/format.h>

#include <filesystem>
#include <map>

#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/image_files.h"
#include "dataset/rig_file.h"
#include "features/pattern_detector.h"
#include "python/bindings.h"
#include "target/board_spec.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

// ---- Detections ------------------------------------------------------------

using IntArray = py::array_t<int, py::array::c_style | py::array::forcecast>;

IntArray ConvertToIntArray(const py::object& given, size_t count,
                           const std::string& name) {
  const py::array array = py::array::ensure(given);
  if (!array) PyErr_Clear();
  const char kind = array ? array.dtype().kind() : ' ';
  if ((kind != 'i' && kind != 'u') || array.ndim() != 1 ||
      static_cast<size_t>(array.size()) != count)
    throw py::value_error(fmt::format(
        "{}: expected an array of {} integers, one per pixel position", name,
        count));
  return IntArray::ensure(array);
}

PyDetection MakeDetection(const std::string& name,
                          const std::pair<int, int>& size,
                          const py::object& pixel_coordinates,
                          const py::object& column_indices,
                          const py::object& row_indices,
                          const py::object& board_ids) {
  const InputVectors pixels = ReadVectors(pixel_coordinates, 2, "pixels");
  if (pixels.axes.size() != 1)
    throw py::value_error("pixels: expected an array of the shape (N, 2)");
  const IntArray columns =
      ConvertToIntArray(column_indices, pixels.count, "columns");
  const IntArray rows = ConvertToIntArray(row_indices, pixels.count, "rows");
  const IntArray boards =
      board_ids.is_none()
          ? IntArray(0)
          : ConvertToIntArray(board_ids, pixels.count, "boards");
  PyDetection detection = {{size.first, size.second}, {name, {}}, {}};
  for (size_t k = 0; k < pixels.count; ++k) {
    const auto i = static_cast<py::ssize_t>(k);
    detection.features.features.push_back(
        {board_ids.is_none() ? 0 : boards.at(i),
         columns.at(i),
         rows.at(i),
         {pixels[k][0], pixels[k][1]}});
  }
  return detection;
}

py::array GetPixels(const PyDetection& detection) {
  const std::vector<Feature>& features = detection.features.features;
  DoubleArray pixels(
      {static_cast<py::ssize_t>(features.size()), py::ssize_t{2}});
  for (size_t k = 0; k < features.size(); ++k)
    for (int axis = 0; axis < 2; ++axis)
      pixels.mutable_at(static_cast<py::ssize_t>(k), axis) =
          features[k].pixel[axis];
  pixels.attr("setflags")(false);
  return pixels;
}

py::array GetIntegers(const PyDetection& detection, int Feature::*member) {
  const std::vector<Feature>& features = detection.features.features;
  py::array_t<int> integers(static_cast<py::ssize_t>(features.size()));
  for (size_t k = 0; k < features.size(); ++k)
    integers.mutable_at(static_cast<py::ssize_t>(k)) = features[k].*member;
  integers.attr("setflags")(false);
  return integers;
}

// Converts an array to the bytes of an image file, so that grey levels are
// computed as for any other file.
std::string EncodePnm(const py::array& image) {
  const bool has_colour = image.ndim() == 3;
  const auto bits = 8 * image.itemsize();
  std::string bytes =
      fmt::format("P{}\n{} {}\n{}\n", has_colour ? 6 : 5, image.shape(1),
                  image.shape(0), (1 << bits) - 1);
  const py::array plain =
      bits == 8
          ? py::array(
                py::array_t<uint8_t, py::array::c_style | py::array::forcecast>(
                    image))
          : py::array(py::array_t<uint16_t, py::array::c_style |
                                                py::array::forcecast>(image));
  const auto* const data = static_cast<const char*>(plain.data());
  const size_t start = bytes.size();
  bytes.append(data, static_cast<size_t>(plain.nbytes()));
  char* const samples = &bytes[start];
  const size_t count = static_cast<size_t>(plain.size());
  if (bits == 16)  // PGM and PPM are big-endian
    for (size_t k = 0; k < count; ++k)
      std::swap(samples[2 * k], samples[2 * k + 1]);
  const size_t width = static_cast<size_t>(image.itemsize());
  if (has_colour)  // PPM has RGB order
    for (size_t k = 0; k < count; k += 3)
      std::swap_ranges(samples + k * width, samples + (k + 1) * width,
                       samples + (k + 2) * width);
  return bytes;
}

std::string CopyPixels(const py::array& image) {
  const bool is_image =
      (image.ndim() == 2 || (image.ndim() == 3 && image.shape(2) == 3)) &&
      image.size() > 0;
  if (image.dtype().kind() != 'u' || image.itemsize() > 2)
    throw py::type_error(
        fmt::format("image: expected an array of uint8 or uint16, not {}",
                    std::string(py::str(image.dtype()))));
  if (!is_image)
    throw py::value_error(
        "image: expected the shape (height, width) or (height, width, 3)");
  return EncodePnm(image);
}

Refinement ParseRefinement(const std::string& name) {
  static const std::map<std::string, Refinement> kNames = {
      {"intensities", Refinement::kIntensities},
      {"gradients-xy", Refinement::kGradientsXY},
      {"gradient-magnitude", Refinement::kGradientMagnitude},
      {"corner-subpix", Refinement::kCornerSubpix},
      {"none", Refinement::kNone}};
  const auto found = kNames.find(name);
  if (found == kNames.end())
    throw py::value_error(
        "refinement: expected intensities, gradients-xy, gradient-magnitude, "
        "corner-subpix or none, not '" +
        name + "'");
  return found->second;
}

PyDetection Detect(const py::object& image, const py::object& pattern,
                   const std::string& name, const std::string& refinement,
                   int window) {
  const std::string board = ToPath(pattern);
  DetectionOptions options;
  options.refinement = ParseRefinement(refinement);
  options.window_px = window;
  if (window < 5 || window > 101 || window % 2 == 0)
    throw py::value_error("window: expected an odd number from 5 to 101");
  PyDetection detection;
  std::string bytes, path = "image";
  if (py::isinstance<py::array>(image)) {
    bytes = CopyPixels(image.cast<py::array>());
  } else {
    path = ToPath(image);
    detection.features.image = fs::path(path).filename().string();
  }
  if (!name.empty()) detection.features.image = name;
  const py::gil_scoped_release released;
  const PatternDetector detector(ReadPatternOrSpec(board), options);
  const GreyImage grey = MakeGreyImage(
      bytes.empty() ? ReadGreyLevels(path) : DecodeGreyLevels(path, bytes));
  detection.size = grey.size;
  if (!IsLargeEnough(grey.size)) return detection;
  ImageDetection found = detector.Detect(grey);
  detection.features.features = std::move(found.features);
  detection.warnings = std::move(found.warnings);
  return detection;
}

// ---- Cameras passed from Python --------------------------------------------

bool IsPath(const py::handle& given) {
  return py::isinstance<py::str>(given) || py::isinstance<py::bytes>(given) ||
         py::hasattr(given, "__fspath__");
}

InputCameraData ReadCamera(const std::string& name, const py::object& given) {
  InputCameraData camera = {name, {}, {}};
  if (IsPath(given)) {
    camera.images.push_back(ToPath(given));
    return camera;
  }
  for (const py::handle item : given) {
    if (IsPath(item))
      camera.images.push_back(ToPath(py::reinterpret_borrow<py::object>(item)));
    else if (py::isinstance<PyDetection>(item))
      camera.detections.push_back(item.cast<PyDetection>());
    else
      throw py::type_error(
          "images: expected paths of images and folders, or Detections");
  }
  if (camera.images.empty() == camera.detections.empty())
    throw py::value_error(
        camera.images.empty()
            ? "images: empty"
            : "images: expected either paths or Detections, not both");
  return camera;
}

}  // namespace

std::vector<InputCameraData> ReadCameras(const py::object& given) {
  if (!py::isinstance<py::dict>(given)) return {ReadCamera("", given)};
  std::vector<InputCameraData> cameras;
  for (const auto& [name, images] : given.cast<py::dict>())
    cameras.push_back(
        ReadCamera(py::str(name), py::reinterpret_borrow<py::object>(images)));
  if (cameras.size() < 2)
    throw py::value_error(
        "images: a rig requires at least two cameras; for a single camera, "
        "pass its images without a name");
  for (const InputCameraData& camera : cameras)
    if (!IsRigCameraName(camera.name))
      throw py::value_error(
          fmt::format("camera name '{}': use only letters, digits, '-' and '_'",
                      camera.name));
  return cameras;
}

Dataset MakeDataset(const InputCameraData& given) {
  Dataset dataset;
  dataset.image_size = given.detections.front().size;
  for (const PyDetection& detection : given.detections) {
    if (detection.size != dataset.image_size)
      throw InputError(fmt::format(
          "image sizes differ: '{}' has {} x {} pixels, '{}' has {} x {}",
          detection.features.image, detection.size.width, detection.size.height,
          given.detections.front().features.image, dataset.image_size.width,
          dataset.image_size.height));
    for (const ImageFeatures& other : dataset.images)
      if (other.image == detection.features.image)
        throw InputError(fmt::format(
            "duplicate image name '{}'; pass a unique name to detect()",
            other.image));
    dataset.images.push_back(detection.features);
  }
  return dataset;
}

// ---- Features in files -----------------------------------------------------

namespace {

py::object LoadFeatures(const py::object& path,
                        const std::pair<int, int>& size) {
  const auto by_camera = ReadFeatures(ToPath(path));
  py::dict all;
  for (const auto& [name, dataset] : by_camera) {
    py::list detections;
    for (const ImageFeatures& image : dataset.images)
      detections.append(PyDetection{{size.first, size.second}, image, {}});
    if (by_camera.size() == 1) return detections;
    all[py::str(name)] = detections;
  }
  return all;
}

void SaveFeatures(const py::object& path, const py::object& given) {
  std::vector<NamedDataset> cameras;
  for (const InputCameraData& camera : ReadCameras(given)) {
    if (camera.detections.empty())
      throw py::type_error("features: expected Detections");
    cameras.push_back({camera.name, MakeDataset(camera)});
  }
  WriteFile(ToPath(path), cameras.size() == 1
                              ? FormatFeatures(cameras.front().dataset)
                              : FormatFeatures(cameras));
}

void BindDetectionClass(py::module_* module) {
  py::class_<PyDetection>(
      *module, "Detection",
      R"(Features of a target, detected in one image; immutable.

Args:
    name: name of the image.
    size: (width, height) of the image in pixels.
    pixels: (N, 2) positions in the image; (0, 0) is the centre of the top-left
        pixel.
    columns: (N,) integers, column of each feature on its board, from 0.
    rows: (N,) integers, row of each feature on its board, from 0.
    boards: (N,) integers, id of each feature's board; default: 0.

Raises:
    ValueError: the lengths differ, or a position is not finite.)")
      .def(py::init(&MakeDetection), py::arg("name"), py::arg("size"),
           py::arg("pixels"), py::arg("columns"), py::arg("rows"),
           py::arg("boards") = py::none())
      .def_property_readonly(
          "name", [](const PyDetection& d) { return d.features.image; },
          "Name of the image.")
      .def_property_readonly(
          "size",
          [](const PyDetection& d) {
            return py::make_tuple(d.size.width, d.size.height);
          },
          "(width, height) of the image, in pixels.")
      .def_property_readonly(
          "pixels", &GetPixels,
          "Positions in the image (N, 2), in pixels; read-only.")
      .def_property_readonly(
          "columns",
          [](const PyDetection& d) { return GetIntegers(d, &Feature::column); },
          "Columns on the board (N,), int32; read-only.")
      .def_property_readonly(
          "rows",
          [](const PyDetection& d) { return GetIntegers(d, &Feature::row); },
          "Rows on the board (N,), int32; read-only.")
      .def_property_readonly(
          "boards",
          [](const PyDetection& d) { return GetIntegers(d, &Feature::board); },
          "Ids of the boards (N,), int32; read-only.")
      .def_property_readonly(
          "remarks", [](const PyDetection& d) { return d.warnings; },
          "Remarks on the image, such as a mirrored target or other tags.")
      .def("__len__",
           [](const PyDetection& d) { return d.features.features.size(); })
      .def("__repr__", [](const PyDetection& d) {
        return fmt::format("<raygrid.Detection '{}' {} x {}, {} features>",
                           d.features.image, d.size.width, d.size.height,
                           d.features.features.size());
      });
}

}  // namespace

void BindDetection(py::module_* module) {
  BindDetectionClass(module);
  module->def("detect", &Detect, py::arg("image"), py::arg("pattern"),
              py::kw_only(), py::arg("name") = "",
              py::arg("refinement") = "intensities", py::arg("window") = 21,
              R"(Detect the features of a target in an image.

Args:
    image: a path, or an array of uint8 or uint16, (height, width) or (height,
        width, 3) in BGR order as in OpenCV.
    pattern: path of a pattern.yaml, or a target specification such as
        'chessboard:9x6:25mm'.
    name: name of the image; default: that of the file.
    refinement: 'intensities', 'gradients-xy', 'gradient-magnitude',
        'corner-subpix' or 'none'.
    window: side of the refinement window in pixels, odd, 5 to 101.

Returns:
    The features; none if the image does not show the target.

Raises:
    Error: the image or pattern cannot be read.
    ValueError: an argument is invalid.
    TypeError: the array's dtype is neither uint8 nor uint16.)");
  module->def("load_features", &LoadFeatures, py::arg("path"), py::arg("size"),
              R"(Read a features.csv.

Args:
    path: the file.
    size: (width, height) of the images in pixels, which the file does not
        contain.

Returns:
    A list with a Detection of each image; for several cameras a dict of such
    lists by camera name.

Raises:
    Error: the file cannot be read or is malformed.)");
  module->def("save_features", &SaveFeatures, py::arg("path"),
              py::arg("features"),
              R"(Write a features.csv, completely or not at all.

Args:
    path: the file to write.
    features: Detections; for a rig a dict of these by camera name.

Raises:
    Error: the file cannot be written, or image names or sizes conflict.)");
}

}  // namespace raygrid
