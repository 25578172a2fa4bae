#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "camera/noncentral_generic.h"
#include "camera_input.h"
#include "commands.h"
#include "dataset/camera_file.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/image_header.h"
#include "dataset/image_times.h"
#include "dataset/parallel_for.h"
#include "dataset/rig_file.h"
#include "help_formatter.h"
#include "image_size_option.h"
#include "json_output.h"
#include "pattern_input.h"
#include "progress_bar.h"
#include "simulate_options.h"
#include "simulation/board_curvature.h"
#include "simulation/image_rendering.h"
#include "simulation/moving_observations.h"
#include "simulation/observation_lines.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"
#include "simulation/simulated_rig.h"

namespace raygrid {
namespace {

// Knot intervals across the image: sufficient for the lenses' local bumps,
// whose width scales with the image.
constexpr double kTruthCells = 80;
// The gap between adjacent boards.
constexpr double kGapSquares = 2;

// Returns the conditions that affect a simulated lens; empty for most lenses.
std::vector<OperatingRange> GetModelRanges(const std::string& name) {
  const OperatingRange position = {OperatingParameter::kLensPosition, 0, 10};
  const OperatingRange temperature = {OperatingParameter::kTemperature, 20, 70};
  if (name == "focusing") return {position};
  if (name == "warming") return {temperature};
  if (name == "focusing-warming") return {position, temperature};
  return {};
}

std::unique_ptr<CameraModel> MakeNamedCamera(const std::string& name,
                                             const RequestedOperatingPoint& at,
                                             const ImageSize& size) {
  const std::vector<OperatingRange> ranges = GetModelRanges(name);
  if (at.HasValues() && ranges.empty())
    throw Error(
        ExitCode::kUsage,
        fmt::format("--at: --lens {} has no operating point; use --lens "
                    "focusing (dioptres), warming (°C) or focusing-warming",
                    name));
  if (ranges.empty()) return MakeSimulatedCamera(name, size);
  SimulatedOperatingPoint state;
  const FixedOperatingPoint held =
      FixRequestedPoint(at, ranges, "--lens " + name);
  for (size_t r = 0; r < ranges.size(); ++r) {
    const double width = ranges[r].high - ranges[r].low;
    if (held[r] && !(std::abs(*held[r] - ranges[r].Center()) <= 1.5 * width))
      throw Error(
          ExitCode::kUsage,
          fmt::format("--at: too far outside the range for --lens {}, {}", name,
                      ranges[r].Text()));
  }
  for (size_t r = 0; r < ranges.size(); ++r) {
    if (!held[r]) continue;
    if (ranges[r].condition == OperatingParameter::kLensPosition)
      state.lens_position = *held[r];
    else
      state.temperature = *held[r];
  }
  return MakeVaryingCamera(state, size);
}

std::shared_ptr<const CameraModel> MakeCamera(
    const SimulateArguments& arguments, const RequestedOperatingPoint& at) {
  if (!arguments.camera.empty()) {
    auto camera = ReadCamera(arguments.camera, at).file.camera;
    const ImageSize size = camera->image_size();
    const std::string why = DescribeSizeLimit(size.width, size.height);
    if (!why.empty()) throw InputError(arguments.camera + ": " + why);
    return camera;
  }
  const ImageSize size = ParseImageSize("--size", arguments.size);
  std::shared_ptr<CameraModel> camera =
      MakeNamedCamera(arguments.lens, at, size);
  if (arguments.image_circle_px > 0)
    camera->SetImageCircle(
        ImageCircle{WholeImage(size).center(),
                    Eigen::Vector2d::Constant(arguments.image_circle_px)});
  return camera;
}

Pattern MakePattern(const SimulateArguments& arguments) {
  return arguments.pattern.empty() ? ChessboardPattern(30, 24, 0.02)
                                   : LoadPattern(arguments.pattern);
}

// Returns a dense grid over the image that represents the lens.
std::shared_ptr<const CameraModel> MakeInitialGrid(const CameraModel& lens) {
  const Area image = WholeImage(lens.image_size());
  const double knot_spacing_px = image.width() / kTruthCells;
  const int columns = NumControlPoints(image.width(), knot_spacing_px);
  const int rows = NumControlPoints(image.height(), knot_spacing_px);
  std::shared_ptr<CameraModel> grid;
  if (lens.IsCentral())
    grid = FitCentralGeneric(lens, image, columns, rows).Clone();
  else
    grid = FitNonCentralGeneric(lens, image, columns, rows).Clone();
  grid->SetImageCircle(lens.image_circle());
  return grid;
}

// Returns the true camera as camera.yaml.
std::string FormatTruth(const CameraModel& camera, bool is_from_file) {
  CameraFile truth;
  truth.camera = is_from_file ? camera.Clone() : MakeInitialGrid(camera);
  truth.name = "simulated";
  return FormatCameraFile(truth);
}

void AddTruth(const std::filesystem::path& folder,
              const SimulatedObservations& observations,
              const CameraModel& camera, bool is_from_file,
              OutputFiles* files) {
  const auto add = [&](const char* name, std::string contents) {
    files->Add((folder / name).string(), std::move(contents));
  };
  add("features.csv", FormatFeatures(observations.dataset));
  add("pattern.yaml", observations.true_pattern.yaml);
  add("true_pattern.yaml", FormatPattern(observations.true_pattern));
  add("true_camera.yaml", FormatTruth(camera, is_from_file));
  if (!camera.IsCentral())
    add("true_lines.csv", FormatObservationLines(camera));
  add("true_poses.csv", FormatPoses(observations.poses));
}

// Coplanar boards next to each other, the first at the origin.
struct BoardLayout {
  std::vector<Eigen::Vector3d> corners_m;  // each board's origin
  Eigen::Vector3d center_m;
};

BoardLayout ConcatenateHorizontally(const Pattern& pattern) {
  BoardLayout layout;
  double x_m = 0, height_m = 0;
  for (const Board& board : pattern.boards) {
    layout.corners_m.emplace_back(x_m, 0, 0);
    const Eigen::Vector3d last = board.NominalPoints().back();
    x_m += last.x() + (2 + kGapSquares) * board.square_m;
    height_m = std::max(height_m, last.y());
  }
  const double gap_m = (2 + kGapSquares) * pattern.boards.back().square_m;
  layout.center_m = {(x_m - gap_m) / 2, height_m / 2, 0};
  return layout;
}

// Renders the images of boards and records the ground truth.
class ImageSimulator {
 public:
  ImageSimulator(const SimulateArguments& arguments,
                 const CommonOptions& common)
      : arguments_(arguments),
        common_(common),
        camera_(MakeCamera(arguments, common.at)),
        rays_(*camera_, NumThreads(common.threads)) {
    Pattern& pattern = truth_.true_pattern;
    pattern = MakePattern(arguments);
    truth_.dataset.image_size = camera_->image_size();
    const double bend_m = arguments.simulation.board_sagitta_m;
    for (Board& board : pattern.boards) {
      surfaces_.emplace_back(board, bend_m);
      board.points = board.NominalPoints();
      board = CurveBoard(board, bend_m);
    }
    layout_ = ConcatenateHorizontally(pattern);
  }

  void RenderAll() {
    const std::filesystem::path folder = arguments_.output;
    RequireCreatableFolder(folder.string());
    ProgressBar progress(common_.quiet);
    const int num_shots = arguments_.simulation.num_shots;
    const int count = arguments_.simulation.num_images * num_shots;
    const std::vector<Pose> poses = RandomPoses(
        *camera_, layout_.center_m, truth_.true_pattern.boards[0].square_m,
        arguments_.simulation.num_images, arguments_.poses, common_.seed);
    for (int i = 0; i < count; ++i) {
      progress.Show("rendering", static_cast<double>(i) / count);
      const std::string name = fmt::format("sim{:04d}.png", i);
      WriteFile((folder / name).string(), Take(i, name, poses[i / num_shots]));
    }
    OutputFiles files;
    AddTruth(folder, truth_, *camera_, !arguments_.camera.empty(), &files);
    files.Commit();
  }

  const SimulatedObservations& truth() const { return truth_; }

 private:
  // Renders one image as a PNG file.
  std::string Take(int index, const std::string& name, const Pose& pose) {
    std::vector<PlacedBoard> placed;
    ImageFeatures seen = {name, {}};
    for (size_t b = 0; b < surfaces_.size(); ++b) {
      const Board& board = truth_.true_pattern.boards[b];
      const Pose board_pose = {pose.rotation, pose * layout_.corners_m[b]};
      placed.push_back({&surfaces_[b], board_pose});
      const auto features = VisibleFeatures(*camera_, board, board_pose);
      seen.features.insert(seen.features.end(), features.begin(),
                           features.end());
      truth_.poses.push_back({name, board.id, board_pose});
    }
    truth_.dataset.images.push_back(std::move(seen));
    ImagingOptions imaging = arguments_.imaging;
    imaging.seed = common_.seed * 1000003 + index;
    const RenderedImage exact =
        RenderImage(rays_, placed, imaging, NumThreads(common_.threads));
    return arguments_.bits == 16
               ? EncodePng(AddNoiseAndQuantize16(exact, imaging))
               : EncodePng(AddNoiseAndQuantize(exact, imaging));
  }

  const SimulateArguments& arguments_;
  const CommonOptions& common_;
  std::shared_ptr<const CameraModel> camera_;
  PixelRays rays_;
  std::vector<BoardSurface> surfaces_;
  BoardLayout layout_;
  SimulatedObservations truth_;
};

// Returns the observations of several cameras.
SimulatedObservations ObserveRig(const SimulateArguments& arguments,
                                 const CommonOptions& common) {
  const std::shared_ptr<const CameraModel> camera =
      MakeCamera(arguments, common.at);
  SimulationOptions options = arguments.simulation;
  options.seed = common.seed;
  options.features_per_image =
      arguments.features_per_image.value_or(options.features_per_image);
  const SimulatedRig cameras =
      arguments.camera_turn_deg == 0
          ? MakeCameraRow(camera, arguments.cameras, arguments.baseline_m)
          : MakeCameraRing(camera, arguments.cameras, arguments.baseline_m,
                           arguments.camera_turn_deg * M_PI / 180);
  const Pattern pattern = MakePattern(arguments);
  SimulatedRigObservations seen =
      arguments.boards_around
          ? SimulateRig(cameras, pattern, RigMotion(), options)
      : arguments.fixed_boards
          ? SimulateRig(cameras, pattern, arguments.fixed, options)
          : SimulateRig(cameras, pattern, options);
  if (arguments.cameras == 1) {
    const SimulatedObservations alone = {seen.datasets[0], seen.true_pattern,
                                         seen.poses[0]};
    OutputFiles single;
    AddTruth(arguments.output, alone, *camera, !arguments.camera.empty(),
             &single);
    single.Commit();
    return alone;
  }
  SimulatedObservations all;
  std::vector<NamedDataset> features;
  std::vector<NamedPoses> poses;
  std::vector<RigFileCamera> rig;
  for (int c = 0; c < arguments.cameras; ++c) {
    const std::string name = fmt::format("cam{}", c);
    const Dataset& dataset = seen.datasets[c];
    features.push_back({name, dataset});
    poses.push_back({name, seen.poses[c]});
    rig.push_back({name, "true_camera.yaml", cameras.camera_from_rig[c]});
    all.dataset.image_size = dataset.image_size;
    all.dataset.images.insert(all.dataset.images.end(), dataset.images.begin(),
                              dataset.images.end());
  }
  OutputFiles files;
  const std::filesystem::path folder = arguments.output;
  const auto add = [&](const char* name, std::string contents) {
    files.Add((folder / name).string(), std::move(contents));
  };
  add("features.csv", FormatFeatures(features));
  add("pattern.yaml", seen.true_pattern.yaml);
  add("true_pattern.yaml", FormatPattern(seen.true_pattern));
  add("true_camera.yaml", FormatTruth(*camera, !arguments.camera.empty()));
  add("true_rig.yaml", FormatRigFile(rig));
  add("true_poses.csv", FormatPoses(poses));
  files.Commit();
  return all;
}

// Returns the observations of consecutive frames of a moving board; also writes
// times.csv.
SimulatedObservations ObserveMoving(const SimulateArguments& arguments,
                                    const CameraModel& camera,
                                    const Pattern& pattern,
                                    const SimulationOptions& options,
                                    OutputFiles* files) {
  HandMotion motion = arguments.motion;
  motion.line_delay_s = arguments.line_delay_us * 1e-6;
  motion.frame_interval_s = 1 / arguments.frames_per_second;
  const MovingObservations moving =
      SimulateMovingObservations(camera, pattern, options, motion);
  ImageTimes times;
  for (size_t i = 0; i < moving.times_s.size(); ++i)
    times[moving.seen.dataset.images[i].image] = moving.times_s[i];
  files->Add((std::filesystem::path(arguments.output) / "times.csv").string(),
             FormatImageTimes(times));
  return moving.seen;
}

int NumFeatures(const Board& board) {
  int count = 0;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      count += board.HasFeature(column, row);
  return count;
}

SimulatedObservations Observe(const SimulateArguments& arguments,
                              const CommonOptions& common) {
  const std::shared_ptr<const CameraModel> camera =
      MakeCamera(arguments, common.at);
  const Pattern pattern = MakePattern(arguments);
  const int num_features = NumFeatures(pattern.boards[0]);
  SimulationOptions options = arguments.simulation;
  options.seed = common.seed;
  options.features_per_image = arguments.features_per_image.value_or(
      std::min(options.features_per_image, num_features));
  if (options.features_per_image > num_features)
    throw Error(ExitCode::kUsage,
                fmt::format("--features-per-image: the board has only {}",
                            num_features));
  OutputFiles files;
  const SimulatedObservations observations =
      arguments.moving
          ? ObserveMoving(arguments, *camera, pattern, options, &files)
          : SimulateObservations(*camera, pattern, options);
  AddTruth(arguments.output, observations, *camera, !arguments.camera.empty(),
           &files);
  files.Commit();
  return observations;
}

SimulatedObservations Render(const SimulateArguments& arguments,
                             const CommonOptions& common) {
  ImageSimulator image_simulator(arguments, common);
  image_simulator.RenderAll();
  return image_simulator.truth();
}

std::string FormatJson(const SimulatedObservations& observations) {
  const ImageSize& size = observations.dataset.image_size;
  nlohmann::ordered_json json;
  json["images"] = observations.dataset.images.size();
  json["image_size"] = {size.width, size.height};
  json["features"] = observations.dataset.num_features();
  return FormatCommandJson(json);
}

void RequireInputsStay(const SimulateArguments& arguments) {
  std::vector<std::string> outputs;
  for (const char* name :
       {"features.csv", "pattern.yaml", "true_camera.yaml", "true_pattern.yaml",
        "times.csv", "true_poses.csv", "true_rig.yaml"})
    outputs.push_back(
        (std::filesystem::path(arguments.output) / name).string());
  RequireNoInputReplaced({arguments.pattern, arguments.camera}, outputs);
}

void Run(SimulateArguments arguments, const CommonOptions& common) {
  arguments.poses.max_tilt_rad = arguments.max_tilt_deg * M_PI / 180;
  arguments.simulation.board_sagitta_m = arguments.board_bend_mm / 1000;
  arguments.simulation.board_deformation_m =
      arguments.board_deformation_mm / 1000;
  if (arguments.poses.min_square_px > arguments.poses.max_square_px)
    throw Error(ExitCode::kUsage, "--min-square-px exceeds --max-square-px");
  if (arguments.render && arguments.board_deformation_mm > 0)
    throw Error(ExitCode::kUsage,
                "--per-view-deformation-mm cannot be combined with --render; "
                "use --target-deformation-mm");
  if (arguments.render && arguments.simulation.shared_noise_px > 0)
    throw Error(ExitCode::kUsage,
                "--correlated-noise-px cannot be combined with --render, which "
                "simulates pixel noise");
  if (arguments.moving &&
      (arguments.render || arguments.cameras > 1 || arguments.fixed_boards ||
       arguments.simulation.num_shots > 1 ||
       arguments.board_deformation_mm > 0))
    throw Error(ExitCode::kUsage,
                "--moving cannot be combined with --render, --cameras, "
                "--fixed-boards, --repeats or --per-view-deformation-mm");
  if (arguments.render && arguments.cameras > 1)
    throw Error(ExitCode::kUsage, "--render supports a single camera only");
  if (arguments.render && arguments.fixed_boards)
    throw Error(ExitCode::kUsage,
                "--fixed-boards is redundant with --render, where the boards "
                "always form one rigid target");
  if (arguments.fixed_boards && MakePattern(arguments).boards.size() < 2)
    throw Error(ExitCode::kUsage,
                "--fixed-boards requires a pattern with at least two boards");
  if (arguments.boards_around &&
      (arguments.fixed.without_shared_views || arguments.move_board_mm > 0))
    throw Error(ExitCode::kUsage,
                "--boards-around cannot be combined with --no-common-boards or "
                "--move-board-mm");
  arguments.fixed.turn_rad = arguments.board_rotation_deg * M_PI / 180;
  arguments.fixed.move_m = arguments.move_board_mm / 1000;
  RequireInputsStay(arguments);
  const SimulatedObservations observations =
      arguments.render ? Render(arguments, common)
      : arguments.cameras > 1 || arguments.fixed_boards
          ? ObserveRig(arguments, common)
          : Observe(arguments, common);
  const ImageSize& size = observations.dataset.image_size;
  if (common.json)
    fmt::print("{}", FormatJson(observations));
  else if (!common.quiet)
    fmt::print("{} features in {} images of {} x {} px: {}\n",
               observations.dataset.num_features(),
               observations.dataset.images.size(), size.width, size.height,
               arguments.output);
}

}  // namespace

void AddSimulate(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "simulate", "Simulate observations or images of a known camera.",
      "raygrid simulate --noise-px 0.05 -o simulated/", common);
  command->footer(
      "Cameras for --lens (details: tools/README.md):\n"
      "  pinhole     65° field of view, almost no distortion\n"
      "  example     OpenCV model with local distortion, 640x480 only\n"
      "  wide        100°, barrel distortion and local distortion\n"
      "  fisheye     145°, local distortion; fisheye190: 190°\n"
      "  noncentral  fisheye with a moving entrance pupil\n"
      "  glass       camera behind a tilted plate of glass, non-central\n"
      "  anamorphic  vertical focal length twice the horizontal one\n"
      "  off-axis    fisheye with axis far from the image centre, tilted "
      "sensor\n"
      "  halves      twice the focal length in the right half of the image\n"
      "  decentred   fisheye with a second element about another axis\n"
      "  mirror      hyperbolic mirror, seen from the side\n"
      "  focusing (0 to 10 dpt), warming (20 to 70 °C), focusing-warming\n"
      "              intrinsics vary with the operating point\n\n" +
      command->get_footer());
  auto arguments = std::make_shared<SimulateArguments>();
  AddSimulateOptions(command, arguments.get());
  BeginGroup(command, help_group::kModel);
  AddAtOption(command, common);
  BeginGroup(command, help_group::kOutput);
  command
      ->add_option("-o,--output", arguments->output,
                   "folder for features.csv, pattern.yaml, images, and the "
                   "ground truth true_*")
      ->option_text("DIR")
      ->required();
  AddHugeOption(command);
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
