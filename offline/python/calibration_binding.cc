#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>

#include "calibration/calibration.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/image_files.h"
#include "dataset/output_folder.h"
#include "dataset/repeated_images.h"
#include "dataset/rig_file.h"
#include "features/board_guess.h"
#include "features/image_circle_detection.h"
#include "features/pattern_detector.h"
#include "features/refinement/camera_refinement.h"
#include "packing/blob_camera.h"
#include "packing/pack.h"
#include "python/bindings.h"
#include "report/result_folder.h"
#include "target/board_spec.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

// ---- Detection -------------------------------------------------------------

// The features of an image: Detection of Python.
struct PyDetection {
  ImageSize size;
  ImageFeatures features;
  std::vector<std::string> remarks;
};

using IntArray = py::array_t<int, py::array::c_style | py::array::forcecast>;

IntArray TakeIntegers(const py::object& given, size_t count,
                      const std::string& name) {
  const py::array array = py::array::ensure(given);
  if (!array) PyErr_Clear();
  const char kind = array ? array.dtype().kind() : ' ';
  if ((kind != 'i' && kind != 'u') || array.ndim() != 1 ||
      static_cast<size_t>(array.size()) != count)
    throw py::value_error(fmt::format(
        "{}: expected an array of {} integers, one for each of pixels", name,
        count));
  return IntArray::ensure(array);
}

PyDetection MakeDetection(const std::string& name,
                          const std::pair<int, int>& size,
                          const py::object& given_pixels,
                          const py::object& given_columns,
                          const py::object& given_rows,
                          const py::object& given_boards) {
  const GivenVectors pixels = TakeVectors(given_pixels, 2, "pixels");
  if (pixels.axes.size() != 1)
    throw py::value_error("pixels: expected an array of the shape (N, 2)");
  const IntArray columns = TakeIntegers(given_columns, pixels.count, "columns");
  const IntArray rows = TakeIntegers(given_rows, pixels.count, "rows");
  const IntArray boards =
      given_boards.is_none()
          ? IntArray(0)
          : TakeIntegers(given_boards, pixels.count, "boards");
  PyDetection detection = {{size.first, size.second}, {name, {}}, {}};
  for (size_t k = 0; k < pixels.count; ++k) {
    const auto i = static_cast<py::ssize_t>(k);
    detection.features.features.push_back(
        {given_boards.is_none() ? 0 : boards.at(i),
         columns.at(i),
         rows.at(i),
         {pixels[k][0], pixels[k][1]}});
  }
  return detection;
}

py::array PixelsOf(const PyDetection& detection) {
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

py::array IntegersOf(const PyDetection& detection, int Feature::*member) {
  const std::vector<Feature>& features = detection.features.features;
  py::array_t<int> integers(static_cast<py::ssize_t>(features.size()));
  for (size_t k = 0; k < features.size(); ++k)
    integers.mutable_at(static_cast<py::ssize_t>(k)) = features[k].*member;
  integers.attr("setflags")(false);
  return integers;
}

// An array as the bytes of an image file, which has the same grey levels then
// as any other file.
std::string PortableMap(const py::array& image) {
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
  if (bits == 16)  // the most significant byte comes first there
    for (size_t k = 0; k < count; ++k)
      std::swap(samples[2 * k], samples[2 * k + 1]);
  const size_t width = static_cast<size_t>(image.itemsize());
  if (has_colour)  // red comes first there
    for (size_t k = 0; k < count; k += 3)
      std::swap_ranges(samples + k * width, samples + (k + 1) * width,
                       samples + (k + 2) * width);
  return bytes;
}

std::string BytesOfImage(const py::array& image) {
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
  return PortableMap(image);
}

Refinement RefinementOf(const std::string& name) {
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
  const std::string board = PathOf(pattern);
  DetectionOptions options;
  options.refinement = RefinementOf(refinement);
  options.window_px = window;
  if (window < 5 || window > 101 || window % 2 == 0)
    throw py::value_error("window: expected an odd number from 5 to 101");
  PyDetection detection;
  std::string bytes, path = "image";
  if (py::isinstance<py::array>(image)) {
    bytes = BytesOfImage(image.cast<py::array>());
  } else {
    path = PathOf(image);
    detection.features.image = fs::path(path).filename().string();
  }
  if (!name.empty()) detection.features.image = name;
  const py::gil_scoped_release released;
  const PatternDetector detector(ReadPatternOrSpec(board), options);
  const GreyImage grey = MakeGreyImage(
      bytes.empty() ? ReadGreyLevels(path) : DecodeGreyLevels(path, bytes));
  detection.size = grey.size;
  if (!CanShowBoard(grey.size)) return detection;
  ImageDetection found = detector.Detect(grey);
  detection.features.features = std::move(found.features);
  detection.remarks = std::move(found.remarks);
  return detection;
}

// ---- Calibration -----------------------------------------------------------

// A camera as Python gave it: images, or features.
struct GivenCamera {
  std::string name;
  std::vector<std::string> images;
  std::vector<PyDetection> detections;
};

// The features of a camera, and the images that they were measured in.
struct MeasuredCamera {
  Dataset dataset;
  std::vector<std::string> paths;
  std::vector<RejectedImage> left_out;
  std::optional<ImageCircle> circle;
};

bool IsPath(const py::handle& given) {
  return py::isinstance<py::str>(given) || py::isinstance<py::bytes>(given) ||
         py::hasattr(given, "__fspath__");
}

GivenCamera TakeCamera(const std::string& name, const py::object& given) {
  GivenCamera camera = {name, {}, {}};
  if (IsPath(given)) {
    camera.images.push_back(PathOf(given));
    return camera;
  }
  for (const py::handle item : given) {
    if (IsPath(item))
      camera.images.push_back(PathOf(py::reinterpret_borrow<py::object>(item)));
    else if (py::isinstance<PyDetection>(item))
      camera.detections.push_back(item.cast<PyDetection>());
    else
      throw py::type_error(
          "images: expected paths of images and folders, or what detect() "
          "returned");
  }
  if (camera.images.empty() == camera.detections.empty())
    throw py::value_error(
        camera.images.empty()
            ? "images: there are none"
            : "images: expected paths or detections, not some of each");
  return camera;
}

// Images, or by the names of a rig's cameras theirs.
std::vector<GivenCamera> TakeCameras(const py::object& given) {
  if (!py::isinstance<py::dict>(given)) return {TakeCamera("", given)};
  std::vector<GivenCamera> cameras;
  for (const auto& [name, images] : given.cast<py::dict>())
    cameras.push_back(
        TakeCamera(py::str(name), py::reinterpret_borrow<py::object>(images)));
  if (cameras.size() < 2)
    throw py::value_error(
        "images: a rig has two cameras or more; give the images of a single "
        "one without its name");
  for (const GivenCamera& camera : cameras)
    if (!IsRigCameraName(camera.name))
      throw py::value_error(
          fmt::format("camera name '{}': give it one of letters, digits, '-' "
                      "and '_'",
                      camera.name));
  return cameras;
}

std::vector<RejectedImage> Listed(const std::vector<SkippedImage>& images) {
  std::vector<RejectedImage> list;
  for (const SkippedImage& image : images)
    list.push_back({fs::path(image.path).filename().string(), image.reason});
  return list;
}

// Images that show the same as others leave: a copy would be predicted by a
// camera that was calibrated with it.
void LeaveOutCopies(MeasuredCamera* camera) {
  Dataset& dataset = camera->dataset;
  const auto repeated = RepeatedImages(dataset);
  for (size_t i = repeated.size(); i-- > 0;) {
    if (!repeated[i]) continue;
    camera->left_out.push_back(
        {dataset.images[i].image, "shows the same as " +
                                      dataset.images[*repeated[i]].image +
                                      ", which is used once"});
    const auto index = static_cast<std::ptrdiff_t>(i);
    dataset.images.erase(dataset.images.begin() + index);
    if (!camera->paths.empty())
      camera->paths.erase(camera->paths.begin() + index);
  }
}

MeasuredCamera MeasureImages(const GivenCamera& given, const Pattern& pattern,
                             const std::string& pattern_name, int num_threads,
                             const std::function<void(double)>& progress) {
  const FoundImages found = FindImages(given.images);
  FolderDetection detection =
      DetectFeatures(found.paths, pattern, {}, nullptr, num_threads, progress);
  if (const auto other =
          GuessOtherBoard(detection, pattern, pattern_name, num_threads))
    throw Error(ExitCode::kTooFew, *other);
  MeasuredCamera camera;
  camera.left_out = Listed(found.left_out);
  for (RejectedImage& skipped : Listed(detection.skipped))
    camera.left_out.push_back(std::move(skipped));
  camera.dataset = std::move(detection.dataset);
  camera.paths = std::move(detection.paths);
  return camera;
}

MeasuredCamera TakeDetections(const GivenCamera& given) {
  MeasuredCamera camera;
  camera.dataset.image_size = given.detections.front().size;
  for (const PyDetection& detection : given.detections) {
    if (detection.size != camera.dataset.image_size)
      throw InputError(fmt::format(
          "image '{}' has {} x {} pixels, and image '{}' has {} x {}; "
          "calibrate "
          "with images of one size",
          detection.features.image, detection.size.width, detection.size.height,
          given.detections.front().features.image,
          camera.dataset.image_size.width, camera.dataset.image_size.height));
    for (const ImageFeatures& other : camera.dataset.images)
      if (other.image == detection.features.image)
        throw InputError(
            fmt::format("two images of the name '{}'; give detect() a name for "
                        "each",
                        other.image));
    camera.dataset.images.push_back(detection.features);
  }
  return camera;
}

// The arguments of calibrate() besides images and pattern.
struct Wishes {
  CalibrationOptions options;
  std::string name, serial;
  bool measures_once = false;
  bool finds_circle = false;
  std::optional<ImageCircle> circle;
};

void RequireUsable(const GivenCamera& given, const MeasuredCamera& camera,
                   const Pattern& pattern, const std::string& pattern_name) {
  const std::string source =
      given.name.empty() ? "features" : "camera " + given.name;
  RequireConsistent(source, camera.dataset, pattern);
  if (camera.dataset.num_features() == 0)
    throw Error(
        ExitCode::kTooFew,
        fmt::format("{}: no board found in any of {} images; check "
                    "columns and rows (inner corners) in {}",
                    source, camera.dataset.images.size(), pattern_name));
}

MeasuredCamera Measure(const GivenCamera& given, const Pattern& pattern,
                       const std::string& pattern_name, const Wishes& wishes,
                       const std::function<void(double)>& progress) {
  const int num_threads = wishes.options.num_threads;
  MeasuredCamera camera =
      given.images.empty()
          ? TakeDetections(given)
          : MeasureImages(given, pattern, pattern_name, num_threads, progress);
  LeaveOutCopies(&camera);
  RequireUsable(given, camera, pattern, pattern_name);
  camera.circle = wishes.circle;
  if (wishes.finds_circle && !camera.paths.empty())
    camera.circle =
        DetectImageCircle(camera.paths, camera.dataset.image_size, num_threads);
  return camera;
}

// A way to measure images again; empty for features alone.
MeasureAgain AgainIn(const MeasuredCamera& camera, const Wishes& wishes,
                     const Task* task) {
  if (camera.paths.empty() || wishes.measures_once) return nullptr;
  return [&camera, task, num_threads = wishes.options.num_threads](
             const CameraModel& model, const Pattern& found_pattern,
             const std::vector<BoardPose>& poses) {
    try {
      return RefineThroughCamera(camera.paths, camera.dataset,
                                 {&model, &found_pattern, poses}, {},
                                 num_threads, [task](double) { task->GoOn(); });
    } catch (const Interruption&) {
      return camera.dataset;
    }
  };
}

// The Calibration of Python.
struct PyCalibration {
  RigResult result;
  int num_threads = 0;

  size_t IndexOf(const std::string& name) const {
    if (name.empty() && !result.IsRig()) return 0;
    for (size_t c = 0; c < result.cameras.size(); ++c)
      if (result.cameras[c].camera.name == name) return c;
    throw py::key_error("camera: there is none of the name '" + name + "'");
  }
};

constexpr double kDetectionPart = 0.2;

RigResult RunCalibration(const std::vector<GivenCamera>& given,
                         const std::string& pattern_name, Wishes wishes,
                         Task* task) {
  const Pattern pattern = ReadPatternOrSpec(pattern_name);
  std::vector<MeasuredCamera> cameras;
  for (const GivenCamera& camera : given) {
    const auto num_before = static_cast<double>(cameras.size());
    cameras.push_back(
        Measure(camera, pattern, pattern_name, wishes, [&](double done) {
          task->GoOn();
          task->Report("detection", kDetectionPart * (num_before + done) /
                                        static_cast<double>(given.size()));
        }));
  }
  task->GoOn();
  std::vector<CalibrationInput> inputs;
  for (size_t c = 0; c < cameras.size(); ++c) {
    CalibrationInput& input = inputs.emplace_back();
    input.name = given.size() > 1 ? given[c].name : wishes.name;
    input.dataset = cameras[c].dataset;
    input.measure_again = AgainIn(cameras[c], wishes, task);
    input.image_circle = cameras[c].circle;
  }
  wishes.options.should_stop = [task] { return task->ShouldStop(); };
  wishes.options.progress = [task](const std::string& stage, double done) {
    task->Report(stage, kDetectionPart + (1 - kDetectionPart) * done);
  };
  RigResult result = Calibrate(inputs, pattern, wishes.options);
  task->GoOn();
  for (size_t c = 0; c < cameras.size(); ++c) {
    CalibrationResult& camera = result.cameras[c];
    camera.camera.serial = wishes.serial;
    camera.rejected_images.insert(camera.rejected_images.end(),
                                  cameras[c].left_out.begin(),
                                  cameras[c].left_out.end());
  }
  task->Report("done", 1);
  return result;
}

void TakeCircle(const py::object& given, Wishes* wishes) {
  if (given.is_none()) return;
  if (py::isinstance<py::str>(given)) {
    if (given.cast<std::string>() != "auto")
      throw py::value_error(
          "image_circle: expected 'auto', None or (x, y, radius) in pixels");
    wishes->finds_circle = true;
    return;
  }
  const GivenVectors numbers = TakeVectors(given, 3, "image_circle");
  if (numbers.count != 1 || !(numbers[0][2] > 0))
    throw py::value_error("image_circle: expected a radius above 0");
  wishes->circle.emplace();
  wishes->circle->center = {numbers[0][0], numbers[0][1]};
  wishes->circle->radii_px.setConstant(numbers[0][2]);
}

PyCalibration CalibrateGiven(
    const py::object& images, const py::object& pattern,
    const std::string& model, const std::optional<double>& cell_px,
    const std::string& area, bool flat_board, bool measure_once,
    bool compare_models, const std::vector<std::string>& hold_out,
    const py::object& image_circle, const std::string& name,
    const std::string& serial, bool any_distance, int threads,
    const py::object& progress) {
  Wishes wishes;
  wishes.name = name;
  wishes.serial = serial;
  wishes.measures_once = measure_once;
  TakeCircle(image_circle, &wishes);
  CalibrationOptions& options = wishes.options;
  options.model = model;
  options.cell_px = cell_px.value_or(0);
  if (cell_px && !(*cell_px >= 2 && *cell_px <= 1e5))
    throw py::value_error("cell_px: expected None, or 2 pixels or more");
  if (area != "image" && area != "features")
    throw py::value_error("area: expected image or features, not '" + area +
                          "'");
  options.area =
      area == "features" ? AreaChoice::kFeatures : AreaChoice::kWholeImage;
  options.flat_board = flat_board;
  options.compare_models = compare_models;
  options.hold_out = hold_out;
  options.any_distance = any_distance;
  options.num_threads = threads;
  RequireBlobText("name", name);
  RequireBlobText("serial", serial);
  const std::vector<GivenCamera> cameras = TakeCameras(images);
  if (cameras.size() > 1 && !name.empty())
    throw py::value_error("name: a rig's names are the keys of images");
  const std::string board = PathOf(pattern);
  PyCalibration calibration;
  calibration.num_threads = threads;
  RunInBackground(progress, [&](Task* task) {
    calibration.result = RunCalibration(cameras, board, wishes, task);
  });
  return calibration;
}

// ---- What is known then ----------------------------------------------------

py::tuple Residuals(const std::vector<FeatureResidual>& residuals) {
  const auto count = static_cast<py::ssize_t>(residuals.size());
  DoubleArray pixels({count, py::ssize_t{2}}), errors({count, py::ssize_t{2}});
  for (py::ssize_t k = 0; k < count; ++k)
    for (int axis = 0; axis < 2; ++axis) {
      const FeatureResidual& residual = residuals[static_cast<size_t>(k)];
      pixels.mutable_at(k, axis) = residual.pixel[axis];
      errors.mutable_at(k, axis) = residual.error_px[axis];
    }
  return py::make_tuple(pixels, errors);
}

py::list PosesOf(const PyCalibration& self, const std::string& camera) {
  py::list poses;
  for (const BoardPose& pose : self.result.cameras[self.IndexOf(camera)].poses)
    poses.append(
        py::make_tuple(pose.image, pose.board,
                       ReadOnly(MatrixOfPose(pose.camera_from_board))));
  return poses;
}

py::list FeaturesOf(const PyCalibration& self, const std::string& camera) {
  py::list detections;
  const Dataset& dataset = self.result.cameras[self.IndexOf(camera)].features;
  for (const ImageFeatures& image : dataset.images)
    detections.append(PyDetection{dataset.image_size, image, {}});
  return detections;
}

py::dict CamerasOf(const PyCalibration& self) {
  py::dict cameras;
  for (const CalibrationResult& camera : self.result.cameras)
    cameras[py::str(camera.camera.name)] = PyCamera{camera.camera};
  return cameras;
}

py::dict CameraFromRig(const PyCalibration& self) {
  py::dict poses;
  for (size_t c = 0; c < self.result.cameras.size(); ++c)
    poses[py::str(self.result.cameras[c].camera.name)] = ReadOnly(MatrixOfPose(
        self.result.IsRig() ? self.result.camera_from_rig[c] : Pose{}));
  return poses;
}

// ---- The result's folder ---------------------------------------------------

PackingFigures FiguresOf(const PackedCamera& packed) {
  PackingFigures figures;
  figures.blob_bytes = packed.blob.size();
  figures.unproject_error_px = packed.unproject_error_px;
  figures.remarks = packed.remarks;
  if (packed.remaps.empty()) return figures;
  const VirtualView& view = packed.remaps[0].view;
  figures.remap_error_px = packed.remaps[0].error_px;
  figures.view = {view.size, view.focal_px, view.center_px};
  return figures;
}

ResultExtras PackResult(const PyCalibration& self, const Task* task) {
  ResultExtras extras;
  for (const CalibrationResult& camera : self.result.cameras) {
    CameraExtras& own = extras.cameras.emplace_back();
    const PackedCamera packed = PackWhatCanBe(
        camera.camera, self.num_threads, [task] { return task->ShouldStop(); });
    task->GoOn();
    own.packing = FiguresOf(packed);
    own.blob = packed.blob;
    if (packed.remaps.empty()) continue;
    CameraFile view;
    view.camera = CameraOfView(packed.remaps[0].view);
    view.name = camera.camera.name;
    own.view = FormatCameraFile(view);
  }
  return extras;
}

// The folder has all files of the result in the end, or those it had before.
void SaveResult(const PyCalibration& self, const py::object& path) {
  const std::string folder = PathOf(path);
  RunInBackground(py::none(), [&](Task* task) {
    const ResultExtras extras = PackResult(self, task);
    OutputFolder output(folder);
    OutputFiles files;
    AddResultFiles(self.result, extras, output.path(), &files);
    files.Commit();
    AddReports(output.path(), &files);
    files.Commit();
    task->GoOn();
    output.Commit(ResultFiles(folder));
  });
}

// ---- Features in files -----------------------------------------------------

py::object LoadFeatures(const py::object& path,
                        const std::pair<int, int>& size) {
  const auto by_camera = ReadFeatures(PathOf(path));
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
  for (const GivenCamera& camera : TakeCameras(given)) {
    if (camera.detections.empty())
      throw py::type_error("features: expected what detect() returned");
    cameras.push_back({camera.name, TakeDetections(camera).dataset});
  }
  WriteFile(PathOf(path), cameras.size() == 1
                              ? FormatFeatures(cameras.front().dataset)
                              : FormatFeatures(cameras));
}

void BindDetection(py::module_* module) {
  py::class_<PyDetection>(
      *module, "Detection",
      "The features of a board that an image shows.\n\nDetection(name, size, "
      "pixels, columns, rows, boards=None): size is (width, height), pixels "
      "(N, 2) with (0, 0) at the centre of the first pixel, columns, rows and "
      "boards (N,) are places on the board and the board's id.")
      .def(py::init(&MakeDetection), py::arg("name"), py::arg("size"),
           py::arg("pixels"), py::arg("columns"), py::arg("rows"),
           py::arg("boards") = py::none())
      .def_property_readonly(
          "name", [](const PyDetection& d) { return d.features.image; },
          "The image's name.")
      .def_property_readonly(
          "size",
          [](const PyDetection& d) {
            return py::make_tuple(d.size.width, d.size.height);
          },
          "(width, height) of the image.")
      .def_property_readonly("pixels", &PixelsOf,
                             "Places in the image, (N, 2), in pixels.")
      .def_property_readonly(
          "columns",
          [](const PyDetection& d) { return IntegersOf(d, &Feature::column); },
          "Columns on the board, (N,).")
      .def_property_readonly(
          "rows",
          [](const PyDetection& d) { return IntegersOf(d, &Feature::row); },
          "Rows on the board, (N,).")
      .def_property_readonly(
          "boards",
          [](const PyDetection& d) { return IntegersOf(d, &Feature::board); },
          "Ids of the boards, (N,).")
      .def_property_readonly(
          "remarks", [](const PyDetection& d) { return d.remarks; },
          "Lines about the image: mirrored, other tags.")
      .def("__len__",
           [](const PyDetection& d) { return d.features.features.size(); })
      .def("__repr__", [](const PyDetection& d) {
        return fmt::format("<raygrid.Detection '{}' {} x {}, {} features>",
                           d.features.image, d.size.width, d.size.height,
                           d.features.features.size());
      });
}

void BindResult(py::module_* module) {
  const auto first_camera = [](const PyCalibration& c) {
    return PyCamera{c.result.cameras.front().camera};
  };
  const auto residuals =
      [](std::vector<FeatureResidual> CalibrationResult::*member) {
        return [member](const PyCalibration& c, const std::string& camera) {
          return Residuals(c.result.cameras[c.IndexOf(camera)].*member);
        };
      };
  py::class_<PyCalibration>(
      *module, "Calibration",
      "What calibrate() found. camera='' is the single one; a rig's have "
      "names.")
      .def_property_readonly("camera", first_camera,
                             "The camera; a rig's first.")
      .def_property_readonly("cameras", &CamerasOf,
                             "Cameras by name; '' if it has none.")
      .def_property_readonly(
          "camera_from_rig", &CameraFromRig,
          "Matrices (4, 4) by name, in metres; the first camera's frame is the "
          "rig's.")
      .def_property_readonly(
          "verdict",
          [](const PyCalibration& c) { return c.result.verdict.word; },
          "pass, warn or fail.")
      .def_property_readonly(
          "reasons",
          [](const PyCalibration& c) { return c.result.verdict.reasons; },
          "Why, line by line.")
      .def_property_readonly(
          "result_json",
          [](const PyCalibration& c) {
            return FormatResultJson(c.result, 0, 0);
          },
          "The text of result.json, without what packing found.")
      .def_property_readonly(
          "pattern",
          [](const PyCalibration& c) {
            return FormatPattern(c.result.pattern);
          },
          "The text of pattern.yaml: the board as it really is.")
      .def("training", residuals(&CalibrationResult::training),
           py::arg("camera") = "",
           "(pixels, errors) of the features calibrated with, both (N, 2): "
           "observed, and projected less observed, in pixels.")
      .def("held_out", residuals(&CalibrationResult::held_out),
           py::arg("camera") = "",
           "(pixels, errors) of images in hold_out, or else of "
           "cross-validation, both (N, 2).")
      .def("poses", &PosesOf, py::arg("camera") = "",
           "(image, board, camera_from_board) of each board seen; the matrix "
           "is (4, 4), in metres.")
      .def("features", &FeaturesOf, py::arg("camera") = "",
           "The Detections that were calibrated with.")
      .def("save", &SaveResult, py::arg("folder"),
           "Writes the folder that 'raygrid calibrate' writes, without "
           "pictures of the images, whole or not at all.")
      .def("__repr__", [](const PyCalibration& c) {
        return fmt::format("<raygrid.Calibration {}, {} camera{}>",
                           c.result.verdict.word, c.result.cameras.size(),
                           c.result.cameras.size() == 1 ? "" : "s");
      });
}

}  // namespace

void BindCalibration(py::module_* module) {
  BindDetection(module);
  BindResult(module);
  module->def(
      "detect", &Detect, py::arg("image"), py::arg("pattern"), py::kw_only(),
      py::arg("name") = "", py::arg("refinement") = "intensities",
      py::arg("window") = 21,
      "The features of a board in an image.\n\nimage: a path, or an array of "
      "uint8 or uint16, (height, width) or (height, width, 3) with blue first "
      "as OpenCV has it. pattern: the path of pattern.yaml, or a board in a "
      "word, as chessboard:9x6:25mm. name: the image's; a file has one. "
      "window: the side of the refinement's, in pixels.");
  module->def(
      "calibrate", &CalibrateGiven, py::arg("images"), py::arg("pattern"),
      py::kw_only(), py::arg("model") = "central-generic",
      py::arg("cell_px") = py::none(), py::arg("area") = "image",
      py::arg("flat_board") = false, py::arg("measure_once") = false,
      py::arg("compare_models") = false,
      py::arg("hold_out") = std::vector<std::string>(),
      py::arg("image_circle") = "auto", py::arg("name") = "",
      py::arg("serial") = "", py::arg("any_distance") = false,
      py::arg("threads") = 0, py::arg("progress") = py::none(),
      "Calibrates a camera, or a rig.\n\nimages: paths of images or folders, "
      "or Detections; of a rig a dict of these by the cameras' names, where "
      "images of one instant have one name. pattern: as for detect(). The "
      "rest is as 'raygrid calibrate --help' says. progress(stage, done, "
      "seconds_left): done is 0 to 1, seconds_left None at first. Ctrl-C and "
      "exceptions of progress end the work; nothing is written before "
      "save().");
  module->def("load_features", &LoadFeatures, py::arg("path"), py::arg("size"),
              "The Detections in features.csv, by the cameras' names if it has "
              "several; size is (width, height) of the images.");
  module->def("save_features", &SaveFeatures, py::arg("path"),
              py::arg("features"),
              "Writes features.csv of Detections, or of those of a rig by the "
              "cameras' names.");
}

}  // namespace raygrid
