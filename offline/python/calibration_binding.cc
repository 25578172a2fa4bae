#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

#include "dataset/error.h"
#include "dataset/image_files.h"
#include "dataset/repeated_images.h"
#include "features/board_guess.h"
#include "features/image_circle_detection.h"
#include "features/pattern_detector.h"
#include "features/refinement/camera_refinement.h"
#include "packing/pack.h"
#include "python/bindings.h"
#include "target/board_spec.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

// ---- Feature detection -----------------------------------------------------

// The features of a camera, and the images in which they were detected.
struct MeasuredCamera {
  Dataset dataset;
  std::vector<std::string> paths;
  std::vector<RejectedImage> left_out;
  std::optional<ImageCircle> circle;
};

std::vector<RejectedImage> ListRejectedImages(
    const std::vector<SkippedImage>& images) {
  std::vector<RejectedImage> list;
  for (const SkippedImage& image : images)
    list.push_back({fs::path(image.path).filename().string(), image.reason});
  return list;
}

// Removes near-duplicate images: cross-validation would otherwise evaluate an
// image on a camera calibrated from its copy.
void ExcludeCopies(MeasuredCamera* camera) {
  Dataset& dataset = camera->dataset;
  const auto repeated = RepeatedImages(dataset);
  for (size_t i = repeated.size(); i-- > 0;) {
    if (!repeated[i]) continue;
    camera->left_out.push_back(
        {dataset.images[i].image,
         "duplicate of " + dataset.images[*repeated[i]].image});
    const auto index = static_cast<std::ptrdiff_t>(i);
    dataset.images.erase(dataset.images.begin() + index);
    if (!camera->paths.empty())
      camera->paths.erase(camera->paths.begin() + index);
  }
}

MeasuredCamera MeasureImages(const InputCameraData& given,
                             const Pattern& pattern,
                             const std::string& pattern_name, int num_threads,
                             const std::function<void(double)>& progress) {
  const FoundImages found = FindImages(given.images);
  FolderDetection detection =
      DetectFeatures(found.paths, pattern, {}, nullptr, num_threads, progress);
  if (const auto other =
          SuggestOtherBoard(detection, pattern, pattern_name, num_threads))
    throw Error(ExitCode::kInsufficientData, *other);
  MeasuredCamera camera;
  camera.left_out = ListRejectedImages(found.left_out);
  for (RejectedImage& skipped : ListRejectedImages(detection.skipped))
    camera.left_out.push_back(std::move(skipped));
  camera.dataset = std::move(detection.dataset);
  camera.paths = std::move(detection.paths);
  return camera;
}

// The arguments of calibrate() other than images and pattern.
struct CalibrationRequest {
  CalibrationOptions options;
  std::string name, serial;
  bool skips_refinement = false;
  bool detects_image_circle = false;
  std::optional<ImageCircle> circle;
};

void RequireUsable(const InputCameraData& given, const MeasuredCamera& camera,
                   const Pattern& pattern, const std::string& pattern_name) {
  const std::string source =
      given.name.empty() ? "features" : "camera " + given.name;
  RequireConsistent(source, camera.dataset, pattern);
  if (camera.dataset.num_features() == 0)
    throw Error(ExitCode::kInsufficientData,
                fmt::format("{}: no target found in any of {} images; {}",
                            source, camera.dataset.images.size(),
                            DescribeExpectedBoards(pattern, pattern_name)));
}

MeasuredCamera Measure(const InputCameraData& given, const Pattern& pattern,
                       const std::string& pattern_name,
                       const CalibrationRequest& request,
                       const std::function<void(double)>& progress) {
  const int num_threads = request.options.num_threads;
  MeasuredCamera camera =
      given.images.empty()
          ? MeasuredCamera{MakeDataset(given), {}, {}, {}}
          : MeasureImages(given, pattern, pattern_name, num_threads, progress);
  ExcludeCopies(&camera);
  RequireUsable(given, camera, pattern, pattern_name);
  camera.circle = request.circle;
  if (request.detects_image_circle && !camera.paths.empty())
    camera.circle =
        DetectImageCircle(camera.paths, camera.dataset.image_size, num_threads);
  return camera;
}

// Returns the callback that refines features with the current model; empty if
// only features are given.
RefineFeaturesCallback MakeRefinement(const MeasuredCamera& camera,
                                      const CalibrationRequest& request,
                                      const Task* task) {
  if (camera.paths.empty() || request.skips_refinement) return nullptr;
  return [&camera, task, num_threads = request.options.num_threads](
             const CameraModel& model, const Pattern& found_pattern,
             const std::vector<BoardPose>& poses) {
    try {
      return RefineFeaturesWithCamera(
          camera.paths, camera.dataset, {&model, &found_pattern, poses}, {},
          num_threads, [task](double) { task->ThrowIfInterrupted(); });
    } catch (const Interruption&) {
      return camera.dataset;
    }
  };
}

// ---- Calibration -----------------------------------------------------------

constexpr double kDetectionProgressFraction = 0.2;

RigResult RunCalibration(const std::vector<InputCameraData>& given,
                         const std::string& pattern_name,
                         CalibrationRequest request, Task* task) {
  const Pattern pattern = ReadPatternOrSpec(pattern_name);
  std::vector<MeasuredCamera> cameras;
  for (const InputCameraData& camera : given) {
    const auto num_before = static_cast<double>(cameras.size());
    cameras.push_back(
        Measure(camera, pattern, pattern_name, request, [&](double done) {
          task->ThrowIfInterrupted();
          task->Report("detection", kDetectionProgressFraction *
                                        (num_before + done) /
                                        static_cast<double>(given.size()));
        }));
  }
  task->ThrowIfInterrupted();
  std::vector<CalibrationInput> inputs;
  for (size_t c = 0; c < cameras.size(); ++c) {
    CalibrationInput& input = inputs.emplace_back();
    input.name = given.size() > 1 ? given[c].name : request.name;
    input.dataset = cameras[c].dataset;
    input.refine_features = MakeRefinement(cameras[c], request, task);
    input.image_circle = cameras[c].circle;
  }
  request.options.should_stop = [task] { return task->ShouldStop(); };
  request.options.progress = [task](const std::string& stage, double done) {
    task->Report(stage, kDetectionProgressFraction +
                            (1 - kDetectionProgressFraction) * done);
  };
  RigResult result = Calibrate(inputs, pattern, request.options);
  task->ThrowIfInterrupted();
  for (size_t c = 0; c < cameras.size(); ++c) {
    CalibrationResult& camera = result.cameras[c];
    camera.camera.serial = request.serial;
    camera.rejected_images.insert(camera.rejected_images.end(),
                                  cameras[c].left_out.begin(),
                                  cameras[c].left_out.end());
  }
  task->Report("done", 1);
  return result;
}

void ParseImageCircleArgument(const py::object& given,
                              CalibrationRequest* request) {
  if (given.is_none()) return;
  if (py::isinstance<py::str>(given)) {
    if (given.cast<std::string>() != "auto")
      throw py::value_error(
          "image_circle: expected 'auto', None or (x, y, radius) in pixels");
    request->detects_image_circle = true;
    return;
  }
  const InputVectors numbers = ReadVectors(given, 3, "image_circle");
  if (numbers.count != 1 || !(numbers[0][2] > 0))
    throw py::value_error("image_circle: expected a positive radius");
  request->circle.emplace();
  request->circle->center = {numbers[0][0], numbers[0][1]};
  request->circle->radii_px.setConstant(numbers[0][2]);
}

// Former names of arguments, which remain valid for one minor version.
class FormerNames {
 public:
  explicit FormerNames(const py::kwargs& given) : keyword_arguments_(given) {}

  template <typename Value>
  void TakeArgument(const char* former, Value* value) {
    if (!keyword_arguments_.contains(former)) return;
    *value = keyword_arguments_[former].cast<Value>();
    ++num_used_;
  }

  // Throws TypeError for unknown argument names.
  void RequireAllUsed() const {
    if (num_used_ != keyword_arguments_.size())
      throw py::type_error(
          "calibrate() got an unexpected keyword argument; see "
          "help(raygrid.calibrate)");
  }

 private:
  const py::kwargs& keyword_arguments_;
  size_t num_used_ = 0;
};

PyCalibration CalibrateInputs(
    const py::object& images, const py::object& pattern,
    const std::string& model, std::optional<double> knot_spacing_px,
    const std::string& area, bool fix_target_geometry, bool rigid_target,
    bool independent_boards, bool refine_features, bool compare_models,
    const std::vector<std::string>& hold_out,
    std::optional<double> duplicate_px, std::optional<double> valid_px,
    const py::object& image_circle, const std::string& name,
    const std::string& serial, bool allow_large_distance, int threads,
    const py::object& progress, const py::kwargs& given) {
  FormerNames former(given);
  former.TakeArgument("cell_px", &knot_spacing_px);
  former.TakeArgument("flat_board", &fix_target_geometry);
  former.TakeArgument("rigid_board", &rigid_target);
  former.TakeArgument("boards_move", &independent_boards);
  bool measure_once = false;
  former.TakeArgument("measure_once", &measure_once);
  former.TakeArgument("same_view_px", &duplicate_px);
  former.RequireAllUsed();
  CalibrationRequest request;
  request.name = name;
  request.serial = serial;
  request.skips_refinement = measure_once || !refine_features;
  ParseImageCircleArgument(image_circle, &request);
  CalibrationOptions& options = request.options;
  options.model = model;
  options.knot_spacing_px = knot_spacing_px.value_or(0);
  if (knot_spacing_px && !(*knot_spacing_px >= 2 && *knot_spacing_px <= 1e5))
    throw py::value_error("knot_spacing_px: expected None, or 2 to 1e5 pixels");
  if (area != "image" && area != "features")
    throw py::value_error("area: expected image or features, not '" + area +
                          "'");
  options.area =
      area == "features" ? AreaChoice::kFeatures : AreaChoice::kWholeImage;
  options.fix_target_geometry = fix_target_geometry;
  options.rigid_board = rigid_target;
  options.independent_boards = independent_boards;
  options.compare_models = compare_models;
  options.hold_out = hold_out;
  options.duplicate_px = duplicate_px;
  if (duplicate_px && !(*duplicate_px >= 0 && *duplicate_px <= 1e5))
    throw py::value_error(
        "duplicate_px: expected None or a number of pixels (0: keep all "
        "images)");
  options.valid_px = valid_px;
  if (valid_px && !(*valid_px >= 1e-3 && *valid_px <= 1e3))
    throw py::value_error("valid_px: expected None, or 0.001 to 1000 pixels");
  options.allow_large_distance = allow_large_distance;
  options.num_threads = threads;
  RequireBlobText("name", name);
  RequireBlobText("serial", serial);
  const std::vector<InputCameraData> cameras = ReadCameras(images);
  if (cameras.size() > 1 && !name.empty())
    throw py::value_error(
        "name: for a rig, camera names are the keys of images");
  const std::string board = ToPath(pattern);
  PyCalibration calibration;
  calibration.num_threads = threads;
  RunInBackground(progress, [&](Task* task) {
    calibration.result = RunCalibration(cameras, board, request, task);
  });
  return calibration;
}

}  // namespace

void BindCalibration(py::module_* module) {
  module->def(
      "calibrate", &CalibrateInputs, py::arg("images"), py::arg("pattern"),
      py::kw_only(), py::arg("model") = "auto",
      py::arg("knot_spacing_px") = py::none(), py::arg("area") = "image",
      py::arg("fix_target_geometry") = false, py::arg("rigid_target") = false,
      py::arg("independent_boards") = false, py::arg("refine_features") = true,
      py::arg("compare_models") = false,
      py::arg("hold_out") = std::vector<std::string>(),
      py::arg("duplicate_px") = py::none(), py::arg("valid_px") = py::none(),
      py::arg("image_circle") = "auto", py::arg("name") = "",
      py::arg("serial") = "", py::arg("any_distance") = false,
      py::arg("threads") = 0, py::arg("progress") = py::none(),
      fmt::format(
          R"(Calibrate a camera or a rig; Calibration.save() writes the files.

Ctrl-C and exceptions that progress raises stop the calibration. The calibration
runs without the GIL.

Args:
    images: paths of images or folders, or Detections; for a rig a dict of these
        by camera name, in which images of one frame share a name.
    pattern: path of a pattern.yaml, or a target specification such as
        'chessboard:9x6:25mm'.
    model: 'auto' (the model with the lowest held-out error), or one of
        '{}'.
    knot_spacing_px: largest knot spacing of the B-spline grid in pixels, 2 to
        1e5; default: chosen by held-out error.
    area: calibrated area: 'image', or 'features' for their bounding box.
    fix_target_geometry: do not estimate target geometry: use the nominal
        points.
    rigid_target: do not estimate per-view target deformation.
    independent_boards: estimate a pose per board, also of boards that are
        rigidly connected.
    refine_features: refine features in the images with the estimated camera.
    compare_models: also calibrate parametric models, for the report.
    hold_out: names of test images, excluded from the calibration; default:
        cross-validation.
    duplicate_px: skip images whose features moved less, in pixels, since a kept
        image; 0: keep all; default: 0.1 % of the longer side, at least 1.
    valid_px: limit of the predicted uncertainty in the valid region, in pixels,
        0.001 to 1000; default: 0.25, or three times the feature noise if larger.
    image_circle: image circle of a fisheye: 'auto' (detected), None, or (x, y,
        radius) in pixels.
    name: name of the camera; for a rig the keys of images are the names.
    serial: serial number of the camera.
    any_distance: accept distances of the target above 20 m.
    threads: number of threads; 0: one per core. Results do not depend on it.
    progress: called as progress(stage, done, seconds_left), with done from 0 to
        1; seconds_left is None at first.

Returns:
    The Calibration. Its verdict may be 'fail'; this raises no exception.

Raises:
    Error: too few images or features (code 3), no initialization (4), no
        convergence (5), or unreadable input (2).
    ValueError, TypeError: an argument is invalid.)",
          fmt::join(ListCalibratedModels(), "', '"))
          .c_str());
}

}  // namespace raygrid
