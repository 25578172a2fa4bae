#include "calibration_input.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <utility>

#include "camera_input.h"
#include "camera_values.h"
#include "capture_metadata.h"
#include "dataset/content_hash.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/image_files.h"
#include "dataset/image_times.h"
#include "dataset/text_encoding.h"
#include "features/board_guess.h"
#include "features/image_circle_detection.h"
#include "features/pattern_detector.h"
#include "image_size_option.h"
#include "interruption.h"
#include "mode_images.h"
#include "mode_options.h"
#include "operating_point_input.h"

namespace raygrid {
namespace {

double ParseKnotSpacingPx(const std::string& text) {
  if (text == "auto") return 0;
  char* end;
  const double value = std::strtod(text.c_str(), &end);
  if (*end != 0 || !(value >= 2) || value > 1e5)
    throw Error(ExitCode::kUsage,
                fmt::format("--knot-spacing-px {}: expected auto or a number "
                            "of pixels, at least 2",
                            text));
  return value;
}

std::optional<double> ParseValidPx(const std::string& text) {
  if (text == "auto") return std::nullopt;
  char* end;
  const double value = std::strtod(text.c_str(), &end);
  if (*end != 0 || !(value >= 1e-3) || value > 1e3)
    throw Error(ExitCode::kUsage,
                fmt::format("--valid-px {}: expected auto, or 0.001 to 1000 "
                            "pixels",
                            text));
  return value;
}

std::optional<double> ParseDuplicatePx(const std::string& text) {
  if (text == "auto") return std::nullopt;
  char* end;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != 0 || !(value >= 0) || value > 1e5)
    throw Error(ExitCode::kUsage,
                fmt::format("--duplicate-px {}: expected auto or a number of "
                            "pixels (0: keep all images)",
                            text));
  return value;
}

struct Interruption {};

// Prints the skipped images, and returns them by file name.
std::vector<RejectedImage> ReportSkippedImages(
    const std::vector<SkippedImage>& images) {
  std::vector<RejectedImage> list;
  for (const SkippedImage& image : images) {
    fmt::print(stderr, "raygrid: skipped {}: {}\n", Printable(image.path),
               Printable(image.reason));
    list.push_back(
        {std::filesystem::path(image.path).filename().string(), image.reason});
  }
  return list;
}

// Returns the callback that refines features with the current model; empty if
// only features are given, or if refinement is disabled.
RefineFeaturesCallback MakeRefinement(const Measurements& measurements,
                                      const CalibrateArguments& arguments,
                                      int num_threads) {
  if (measurements.paths.empty() || arguments.measure_once) return nullptr;
  return [&measurements, num_threads](const CameraModel& camera,
                                      const Pattern& found_pattern,
                                      const std::vector<BoardPose>& poses) {
    const auto go_on = [](double) {
      if (IsInterrupted()) throw Interruption();
    };
    try {
      return RefineModes(measurements, {&camera, &found_pattern, poses},
                         num_threads, go_on);
    } catch (const Interruption&) {
      return measurements.dataset;
    }
  };
}

// Throws Error(kInsufficientData) without features, and the errors of
// RequireConsistent.
void RequireUsable(const std::string& source,
                   const CalibrateArguments& arguments,
                   const Measurements& measurements, const Pattern& pattern) {
  const Dataset& dataset = measurements.dataset;
  RequireConsistent(source, dataset, pattern);
  if (dataset.num_features() == 0)
    throw Error(
        ExitCode::kInsufficientData,
        fmt::format("{}no target found in any of {} images; {}",
                    arguments.cameras.empty() ? "" : source + ": ",
                    dataset.images.size(),
                    DescribeExpectedBoards(pattern, arguments.pattern)));
}

// ---- Image circle ----------------------------------------------------------

// Parses "X,Y,RADIUS".
ImageCircle ParseImageCircle(const std::string& text) {
  ImageCircle circle;
  double radius_px = 0;
  int length = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%n", &circle.center.x(),
                  &circle.center.y(), &radius_px, &length) != 3 ||
      static_cast<size_t>(length) != text.size() ||
      !circle.center.allFinite() || !(radius_px > 0 && radius_px < 1e6))
    throw Error(ExitCode::kUsage,
                fmt::format("--image-circle {}: expected auto, none, or "
                            "X,Y,RADIUS in pixels, such as 320,240,250",
                            text));
  circle.radii_px.setConstant(radius_px);
  return circle;
}

// Returns the given image circle, or otherwise the one detected from the dark
// corners of the calibrated images.
std::optional<ImageCircle> GetImageCircle(const Measurements& measurements,
                                          const std::string& word,
                                          int num_threads) {
  if (word == "none") return std::nullopt;
  if (word != "auto") return ParseImageCircle(word);
  std::vector<std::string> paths = measurements.paths;
  paths.resize(std::min(paths.size(), NumCalibratedImages(measurements)));
  return DetectImageCircle(paths, measurements.dataset.image_size, num_threads);
}

// ---- Cameras ---------------------------------------------------------------

std::vector<RigCameraImages> ParseCameras(const CalibrateArguments& arguments) {
  if (arguments.cameras.empty() && arguments.rig.empty())
    return {{"", arguments.images}};
  std::vector<RigCameraImages> cameras = arguments.rig;
  if (cameras.empty()) {
    const std::vector<NamedValue> folders =
        ParseCameraValues("--camera", "FOLDER", arguments.cameras);
    RequireSeparateFolderNames("--camera", folders);
    for (const auto& [name, folder] : folders)
      cameras.push_back({name, {folder}});
  }
  if (cameras.size() == 1)
    throw Error(ExitCode::kUsage,
                "a rig requires at least two cameras; for a single camera, "
                "omit --camera");
  return cameras;
}

ImageSize GetSingleCameraSize(const CalibrateArguments& arguments) {
  if (arguments.image_sizes.empty())
    throw Error(ExitCode::kUsage, "--features requires --image-size WxH");
  if (arguments.image_sizes.size() > 1)
    throw Error(ExitCode::kUsage,
                "--image-size is specified several times, but the features "
                "come from a single camera");
  return ParseImageSize("--image-size", arguments.image_sizes.front());
}

// WxH applies to all cameras without their own NAME=WxH.
ImageSize GetCameraSize(const std::string& camera,
                        const CalibrateArguments& arguments) {
  std::string size;
  for (const std::string& text : arguments.image_sizes) {
    const NamedValue given = ParseNamedValue(text);
    if (given.name == camera || (given.name.empty() && size.empty()))
      size = given.value;
  }
  if (size.empty())
    throw Error(ExitCode::kUsage,
                fmt::format("--features requires --image-size WxH, or "
                            "--image-size {}=WxH for its camera '{}'",
                            camera, camera));
  return ParseImageSize("--image-size", size);
}

void RequireCameraSizes(const CalibrateArguments& arguments,
                        const FeaturesByCamera& given) {
  for (const std::string& text : arguments.image_sizes) {
    const std::string name = ParseNamedValue(text).name;
    if (!name.empty() && !given.count(name))
      throw Error(ExitCode::kUsage,
                  fmt::format("--image-size {}: {} has no camera '{}'", text,
                              arguments.features, name));
  }
}

std::vector<Measurements> ReadCameraInputs(const CalibrateArguments& arguments,
                                           const FeaturesByCamera& given,
                                           const Pattern& pattern) {
  const bool is_rig = given.size() > 1;
  if (is_rig) RequireCameraSizes(arguments, given);
  std::vector<Measurements> cameras;
  for (const auto& [name, dataset] : given) {
    if (is_rig) RequireCameraName(name);
    Measurements& camera = cameras.emplace_back();
    if (is_rig) camera.camera = name;
    camera.dataset = dataset;
    camera.dataset.image_size = is_rig ? GetCameraSize(name, arguments)
                                       : GetSingleCameraSize(arguments);
    ExcludeCopies(&camera, arguments.hold_out);
    camera.image_circle = GetImageCircle(camera, arguments.image_circle, 1);
    RequireUsable(arguments.features + (is_rig ? ", camera " + name : ""),
                  arguments, camera, pattern);
  }
  return cameras;
}

// Detects the features in the images of one camera, including all sensor modes.
Measurements MeasureModes(const std::vector<std::string>& images,
                          const CalibrateArguments& arguments,
                          const CommonOptions& common, const Pattern& pattern,
                          const std::function<void(double)>& progress) {
  const ModeFolders folders = GroupByMode(images, arguments.modes);
  const auto measure = [&](const std::vector<std::string>& given) {
    return UsesExifValues(arguments)
               ? MeasureWithExif(given, arguments, common, pattern, progress)
               : Measure(given, pattern, arguments.pattern, common, progress,
                         arguments.hold_out);
  };
  Measurements measurements =
      arguments.cameras_at.empty()
          ? measure(folders.calibrated)
          : MeasureFoldersAt(arguments, common, pattern, progress);
  for (const auto& [folder, text] : folders.modes)
    AppendModeMeasurements(ParseMode(text, measurements.dataset.image_size),
                           folder, measure({folder}), &measurements);
  measurements.image_circle =
      GetImageCircle(measurements, arguments.image_circle, common.threads);
  return measurements;
}

std::vector<Measurements> MeasureCameras(const CalibrateArguments& arguments,
                                         const CommonOptions& common,
                                         const Pattern& pattern,
                                         ProgressBar* bar) {
  const std::vector<RigCameraImages> named = ParseCameras(arguments);
  if (!arguments.modes.empty() && named.size() > 1)
    throw Error(ExitCode::kUsage,
                "--mode supports a single camera only; calibrate the cameras "
                "of a rig separately");
  for (const RigCameraImages& camera : named)
    if (!camera.images.empty())
      FindImages(camera.images);  // throws before any time-consuming step
  std::vector<Measurements> cameras;
  for (const auto& [name, images] : named) {
    const std::string start = name.empty() ? "" : name + ": ";
    const auto num_before = static_cast<double>(cameras.size());
    cameras.push_back(
        MeasureModes(images, arguments, common, pattern, [&](double done) {
          bar->Show(start + "detection", 0.2 * (num_before + done) /
                                             static_cast<double>(named.size()));
        }));
    cameras.back().camera = name;
    RequireUsable(name.empty() ? "detected features" : "camera " + name,
                  arguments, cameras.back(), pattern);
  }
  return cameras;
}

}  // namespace

namespace {

// The line delay depends on the sensor mode, and its estimation requires
// timestamps.
void RequireTimes(const CalibrateArguments& arguments) {
  if (!arguments.rolling_shutter && !arguments.times.empty())
    throw Error(ExitCode::kUsage, "--timestamps requires --rolling-shutter");
  if (!arguments.rolling_shutter) return;
  if (!arguments.modes.empty())
    throw Error(ExitCode::kUsage,
                "--rolling-shutter cannot be combined with --mode, since the "
                "line delay depends on the sensor mode");
  if (!arguments.condition.empty())
    throw Error(ExitCode::kUsage,
                "--rolling-shutter cannot be combined with --vary-with; "
                "calibrate at one operating point");
  if (arguments.times.empty() && arguments.session_times.empty())
    throw Error(ExitCode::kUsage,
                "--rolling-shutter requires timestamps: pass --timestamps "
                "times.csv with the columns image,time_s, a bag, or a session "
                "recorded with raygrid capture --every-frame");
  if (!arguments.times.empty()) ReadImageTimes(arguments.times);
}

// Memory grows with the number of features, and time also with the square of
// the number of images; beyond some hundred images, the accuracy hardly
// improves.
void CheckFeatureLimit(const std::string& path, const FeaturesByCamera& given) {
  constexpr size_t kMost = 500000;
  size_t num_features = 0, num_images = 0;
  for (const auto& [name, dataset] : given) {
    num_features += dataset.num_features();
    num_images += dataset.images.size();
  }
  if (num_features <= kMost) return;
  throw InputError(
      fmt::format("{}: {} features in {} images exceed the limit of {}; keep "
                  "one of every {} images (a few hundred suffice)",
                  path, num_features, num_images, kMost,
                  (num_features + kMost - 1) / kMost));
}

}  // namespace

FeaturesByCamera ReadFeatureInputs(const CalibrateArguments& arguments) {
  if (!arguments.images.empty() + !arguments.features.empty() +
          !arguments.cameras_at.empty() + arguments.HasCameraImages() !=
      1)
    throw Error(
        ExitCode::kUsage,
        "specify exactly one of images, --camera, --images-at and --features");
  if (!arguments.features.empty() && !arguments.modes.empty())
    throw Error(ExitCode::kUsage,
                "--mode applies to images, not to --features");
  for (const std::string& image : arguments.images)
    if (std::filesystem::path(image).extension() == ".csv")
      throw Error(
          ExitCode::kUsage,
          fmt::format(
              "{}: is a table, not an image; pass it with --features {}", image,
              image));
  RequireTimes(arguments);
  if (arguments.features.empty()) return {};
  FeaturesByCamera given = ReadFeatures(arguments.features);
  CheckFeatureLimit(arguments.features, given);
  return given;
}

void ExcludeCopies(Measurements* measurements,
                   const std::vector<std::string>& hold_out) {
  Dataset& dataset = measurements->dataset;
  std::vector<std::string>& paths = measurements->paths;
  std::vector<std::optional<size_t>> repeated = RepeatedImages(dataset);
  const auto is_held_out = [&](size_t image) {
    return std::count(hold_out.begin(), hold_out.end(),
                      dataset.images[image].image) > 0;
  };
  for (size_t i = 0; i < repeated.size(); ++i)
    if (repeated[i] && is_held_out(i) != is_held_out(*repeated[i]))
      repeated[i].reset();
  std::vector<SkippedImage> copies;
  for (size_t i = 0; i < repeated.size(); ++i)
    if (repeated[i]) {
      const std::string& original = dataset.images[*repeated[i]].image;
      copies.push_back({dataset.images[i].image, "duplicate of " + original});
      measurements->copies.push_back({original, dataset.images[i].image});
    }
  for (size_t i = repeated.size(); i-- > 0;) {
    if (!repeated[i]) continue;
    const auto index = static_cast<std::ptrdiff_t>(i);
    dataset.images.erase(dataset.images.begin() + index);
    if (!paths.empty()) paths.erase(paths.begin() + index);
  }
  const std::vector<RejectedImage> named = ReportSkippedImages(copies);
  measurements->left_out.insert(measurements->left_out.end(), named.begin(),
                                named.end());
}

size_t NumCalibratedImages(const Measurements& measurements) {
  return measurements.modes.empty() ? measurements.dataset.images.size()
                                    : measurements.modes[0].first;
}

void Append(Measurements more, Measurements* measurements) {
  const auto append = [](auto& from, auto* to) {
    to->insert(to->end(), std::make_move_iterator(from.begin()),
               std::make_move_iterator(from.end()));
  };
  if (measurements->dataset.image_size == ImageSize())
    measurements->dataset.image_size = more.dataset.image_size;
  append(more.dataset.images, &measurements->dataset.images);
  append(more.paths, &measurements->paths);
  append(more.skipped, &measurements->skipped);
  append(more.left_out, &measurements->left_out);
  measurements->condition_values.merge(more.condition_values);
}

Measurements DetectAll(const std::vector<std::string>& images,
                       const Pattern& pattern, const std::string& pattern_name,
                       const CommonOptions& common,
                       const std::function<void(double)>& progress) {
  const FoundImages found = FindImages(images);
  const DetectionCache cache(DetectionCache::DefaultFolder());
  FolderDetection detection = DetectFeatures(found.paths, pattern, {}, &cache,
                                             common.threads, progress);
  Measurements measurements;
  measurements.skipped = ReportSkippedImages(detection.skipped);
  measurements.left_out = ReportSkippedImages(found.left_out);
  if (const auto other =
          SuggestOtherBoard(detection, pattern, pattern_name, common.threads))
    throw Error(ExitCode::kInsufficientData, *other);
  if (!common.quiet) {
    for (const std::string& warning : SummarizeWarnings(detection))
      fmt::print(stderr, "raygrid: {}\n", Printable(warning));
    if (!detection.turned.empty())
      fmt::print(stderr, "raygrid: {}\n",
                 Printable(WarnAboutOrientation(detection.turned)));
  }
  measurements.dataset = std::move(detection.dataset);
  measurements.paths = std::move(detection.paths);
  return measurements;
}

Measurements Measure(const std::vector<std::string>& images,
                     const Pattern& pattern, const std::string& pattern_name,
                     const CommonOptions& common,
                     const std::function<void(double)>& progress,
                     const std::vector<std::string>& hold_out) {
  Measurements measurements =
      DetectAll(images, pattern, pattern_name, common, progress);
  ExcludeCopies(&measurements, hold_out);
  return measurements;
}

std::vector<Measurements> CollectMeasurements(
    const CalibrateArguments& arguments, const CommonOptions& common,
    const FeaturesByCamera& given, const Pattern& pattern, ProgressBar* bar) {
  std::vector<Measurements> cameras =
      given.empty() ? MeasureCameras(arguments, common, pattern, bar)
                    : ReadCameraInputs(arguments, given, pattern);
  if (cameras.size() > 1 && arguments.sync_by == "number")
    for (Measurements& camera : cameras)
      RenameImagesByNumber("camera " + camera.camera, &camera.dataset);
  return cameras;
}

IntrinsicsByCamera ReadKnownIntrinsics(const CalibrateArguments& arguments,
                                       const FeaturesByCamera& given) {
  std::vector<std::string> names;
  for (const auto& [name, dataset] : given) names.push_back(name);
  if (given.empty())
    for (const RigCameraImages& camera : ParseCameras(arguments))
      names.push_back(camera.camera);
  IntrinsicsByCamera known = ReadKnownIntrinsics(arguments.intrinsics, names);
  if (known.empty()) return known;
  if (arguments.rolling_shutter)
    throw Error(ExitCode::kUsage,
                "--intrinsics cannot be combined with --rolling-shutter");
  const char* unused = arguments.model != "auto" ? "--model"
                       : arguments.knot_spacing_px != "auto"
                           ? "--knot-spacing-px"
                       : arguments.allow_noncentral ? "--allow-noncentral"
                                                    : nullptr;
  if (known.size() == names.size() && unused)
    throw Error(ExitCode::kUsage,
                fmt::format("{} has no effect, since the intrinsics of all "
                            "cameras are known; omit it",
                            unused));
  return known;
}

std::vector<CalibrationInput> MakeCalibrationInputs(
    const std::vector<Measurements>& cameras,
    const CaptureMetadata& capture_metadata,
    const CalibrateArguments& arguments, const IntrinsicsByCamera& intrinsics,
    int num_threads, CheckpointFile* checkpoints) {
  std::vector<CalibrationInput> inputs;
  for (size_t c = 0; c < cameras.size(); ++c) {
    inputs.push_back(
        {arguments.name.empty() ? cameras[c].camera : arguments.name,
         cameras[c].dataset, MakeRefinement(cameras[c], arguments, num_threads),
         checkpoints->Of(c),
         [=](const Checkpoint& done) { checkpoints->Save(c, done); },
         cameras[c].image_circle, cameras[c].skipped,
         capture_metadata.times[c]});
    if (const auto known = intrinsics.find(cameras[c].camera);
        known != intrinsics.end())
      inputs.back().intrinsics = known->second.file;
  }
  return inputs;
}

CalibrationOptions MakeCalibrationOptions(const CalibrateArguments& arguments,
                                          const CommonOptions& common,
                                          ProgressBar* bar) {
  CalibrationOptions options;
  // An operating-point model consists of central grids.
  const bool is_stack =
      arguments.model == "auto" && !arguments.condition.empty();
  options.model = is_stack ? models::kCentralGeneric : arguments.model;
  options.allow_noncentral = arguments.allow_noncentral;
  options.knot_spacing_px = ParseKnotSpacingPx(arguments.knot_spacing_px);
  options.area = arguments.area == "features" ? AreaChoice::kFeatures
                                              : AreaChoice::kWholeImage;
  if (!arguments.like.empty()) {
    const CameraFile like = ReadCamera(arguments.like).file;
    options.like = like.camera;
    if (like.spread)
      options.prior_population =
          std::make_shared<PopulationCovariance>(*like.spread);
  }
  options.fix_target_geometry = arguments.fix_target_geometry;
  options.rigid_board = arguments.rigid_board;
  options.independent_boards = arguments.independent_boards;
  options.compare_models = !arguments.skip_comparison;
  options.hold_out = arguments.hold_out;
  options.duplicate_px = ParseDuplicatePx(arguments.duplicate_px);
  options.valid_px = ParseValidPx(arguments.valid_px);
  options.num_threads = common.threads;
  options.allow_large_distance = common.yes;
  options.should_stop = IsInterrupted;
  options.progress = [bar](const std::string& stage, double done) {
    bar->Show(stage, 0.2 + 0.7 * done);
  };
  return options;
}

void RequireNoInputReplaced(const CalibrateArguments& arguments,
                            const std::vector<std::string>& images) {
  std::vector<std::string> inputs = images, outputs;
  inputs.push_back(arguments.pattern);
  inputs.push_back(arguments.features);
  inputs.push_back(arguments.times);
  inputs.push_back(arguments.conditions);
  inputs.push_back(arguments.like);
  for (const std::string& text : arguments.intrinsics) {
    const NamedValue known = ParseNamedValue(text);
    inputs.push_back(known.value);
    // The camera.yaml of any camera of a rig.
    const auto folder = std::filesystem::absolute(known.value).parent_path();
    std::error_code ignored;
    if (std::filesystem::equivalent(folder.parent_path(), arguments.output,
                                    ignored))
      outputs.push_back((folder / "camera.yaml").string());
  }
  for (const char* name :
       {"camera.raygrid", "camera.yaml", "example_after.png",
        "example_before.png", "features.csv", "pattern.yaml", "poses.csv",
        "report.html", "residuals.csv", "result.json", "resume.json",
        "rig.yaml", "thumbnails.json", "uncertainty.png", "view.camera.yaml"})
    outputs.push_back(
        (std::filesystem::path(arguments.output) / name).string());
  RequireNoInputReplaced(inputs, outputs);
}

std::string SerializeInputs(const CalibrateArguments& arguments,
                            const CommonOptions& common,
                            const std::vector<Measurements>& cameras,
                            const CaptureMetadata& capture_metadata,
                            const IntrinsicsByCamera& intrinsics,
                            const Pattern& pattern) {
  ContentHash hash;
  hash.Add(RAYGRID_VERSION);
  hash.Add(FormatPattern(pattern));
  for (const Measurements& camera : cameras) {
    const ImageSize& size = camera.dataset.image_size;
    hash.Add(
        fmt::format("{} {} {}", size.width, size.height, camera.paths.size()));
    for (const ImageFeatures& image : camera.dataset.images) {
      hash.Add(image.image);
      for (const Feature& f : image.features)
        hash.Add(fmt::format("{} {} {} {:.17g} {:.17g}", f.board, f.column,
                             f.row, f.pixel.x(), f.pixel.y()));
    }
  }
  hash.Add(fmt::format("{} {} {} {} {} {} {} {} {} {} {} {}", arguments.model,
                       arguments.allow_noncentral, arguments.knot_spacing_px,
                       arguments.duplicate_px, arguments.area,
                       arguments.image_circle, arguments.fix_target_geometry,
                       arguments.rigid_board, arguments.independent_boards,
                       arguments.measure_once, arguments.valid_px,
                       common.seed));
  for (const std::string& image : arguments.hold_out) hash.Add(image);
  for (const std::string& mode : arguments.modes) hash.Add(mode);
  if (const auto& conditions = capture_metadata.conditions) {
    for (const OperatingParameter condition : conditions->conditions)
      hash.Add(OperatingParameterName(condition));
    for (const auto& [image, values] : conditions->values)
      hash.Add(fmt::format("{} {:.17g}", image, fmt::join(values, " ")));
  }
  for (const auto& times : capture_metadata.times)
    if (times) hash.Add(FormatImageTimes(*times));
  if (!arguments.like.empty()) hash.Add(ReadFile(arguments.like));
  for (const auto& [name, known] : intrinsics) {
    hash.Add(name);
    hash.Add(FormatCameraFile(*known.file));
  }
  return hash.Text();
}

void AddRigImageOptions(CLI::App* command, std::vector<std::string>* folders,
                        std::string* sync_by, std::string* features) {
  command
      ->add_option("--camera", *folders,
                   "images of one camera of a rig, or BAG:TOPIC; repeatable. "
                   "Synchronized images have the same name, or near stamps")
      ->option_text("NAME=DIR")
      ->allow_extra_args(false);
  command
      ->add_option("--sync-by", *sync_by,
                   "match images of a rig by file name, or by the last number "
                   "in it (left01, right01)")
      ->check(CLI::IsMember({"name", "number"}))
      ->option_text("name|number")
      ->capture_default_str();
  command
      ->add_option(
          "--features", *features,
          "features.csv instead of images; for a rig, with a column camera")
      ->option_text("FILE");
}

}  // namespace raygrid
