#include "simulate_options.h"

#include "help_formatter.h"
#include "pattern_input.h"

namespace raygrid {
namespace {

void AddObservationOptions(CLI::App* command, SimulateArguments* arguments) {
  SimulationOptions& simulation = arguments->simulation;
  BeginGroup(command, "Observations");
  command->add_option("--images", simulation.num_images, "number of views")
      ->option_text("N")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command
      ->add_option("--repeats", simulation.num_shots,
                   "images per view, which differ only in noise")
      ->option_text("N")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command
      ->add_option("--features-per-image", arguments->features_per_image,
                   "features per image without --render (default: 240, or all "
                   "features of the target)")
      ->option_text("N")
      ->check(CLI::Range(1, 1000000));
  command
      ->add_option("--noise-px", simulation.noise_px,
                   "standard deviation of white feature noise, per "
                   "coordinate; ignored with --render")
      ->option_text("PX")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command
      ->add_option("--correlated-noise-px", simulation.shared_noise_px,
                   "standard deviation of spatially correlated noise, per "
                   "coordinate; ignored with --render")
      ->option_text("PX")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command
      ->add_option("--correlation-length", simulation.shared_noise_features,
                   "correlation length of that noise, in feature spacings: "
                   "distance at which the correlation is exp(-1/2)")
      ->option_text("N")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  command
      ->add_option("--target-deformation-mm", arguments->board_bend_mm,
                   "static deformation: deflection at the edges of the target")
      ->option_text("MM")
      ->check(CLI::Range(-1000.0, 1000.0))
      ->capture_default_str();
  command
      ->add_option("--per-view-deformation-mm", arguments->board_deformation_mm,
                   "standard deviation of a random per-view deflection; "
                   "ignored with --render")
      ->option_text("MM")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
}

void AddImagingOptions(CLI::App* command, SimulateArguments* arguments) {
  ImagingOptions& imaging = arguments->imaging;
  BeginGroup(command, "Rendering");
  const auto add = [command](const char* name, double& value, const char* unit,
                             const char* description, double low, double high) {
    command->add_option(name, value, description)
        ->option_text(unit)
        ->check(CLI::Range(low, high))
        ->capture_default_str();
  };
  command->add_flag(
      "--render", arguments->render,
      "render images; features.csv then contains exact positions");
  add("--blur-px", imaging.blur_px, "PX", "optical blur, 1 σ", 0, 50);
  add("--read-noise", imaging.read_noise, "LEVELS", "read noise, 1 σ", 0, 255);
  add("--shot-noise", imaging.shot_noise, "LEVELS",
      "shot noise variance per grey level", 0, 255);
  add("--vignetting", imaging.vignetting, "0..1",
      "fraction of light lost in the corners", 0, 0.99);
  add("--gamma", imaging.gamma, "X",
      "gamma correction of the stored grey levels", 0.1, 10);
  add("--exposure", imaging.exposure, "X",
      "exposure factor, multiplies all grey levels", 0.01, 100);
  add("--max-tilt-deg", arguments->max_tilt_deg, "DEG",
      "maximum tilt of rendered targets", 0, 80);
  add("--min-square-px", arguments->poses.min_square_px, "PX",
      "minimum square width in rendered images", 1, 1000);
  add("--max-square-px", arguments->poses.max_square_px, "PX",
      "maximum square width in rendered images", 1, 1000);
  command
      ->add_option("--samples-per-pixel", imaging.samples_per_pixel,
                   "number of samples per pixel along each axis")
      ->option_text("N")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command->add_option("--bits", arguments->bits, "bit depth of the images")
      ->check(CLI::IsMember({8, 16}))
      ->option_text("8|16")
      ->capture_default_str();
}

void AddMultiBoardOptions(CLI::App* command, SimulateArguments* arguments) {
  BeginGroup(command, help_group::kTarget);
  CLI::Option* fixed = command->add_flag(
      "--fixed-boards", arguments->fixed_boards,
      "treat the boards of the pattern as one rigid target, side by side");
  command
      ->add_option("--board-gap-m", arguments->fixed.gap_m,
                   "gap between the boards of the rigid target")
      ->option_text("M")
      ->check(CLI::Range(0.0, 100.0))
      ->needs(fixed)
      ->capture_default_str();
  command
      ->add_option("--board-turn-deg", arguments->board_rotation_deg,
                   "angle between neighbouring boards of the rigid target")
      ->option_text("DEG")
      ->check(CLI::Range(-180.0, 180.0))
      ->needs(fixed)
      ->capture_default_str();
  command
      ->add_flag("--boards-around", arguments->boards_around,
                 "place one fixed board in front of each camera, and move the "
                 "rig")
      ->needs(fixed);
  command
      ->add_flag("--no-common-boards", arguments->fixed.without_shared_views,
                 "show each fixed board in at most one camera per frame")
      ->needs(fixed);
  command
      ->add_option("--move-board-mm", arguments->move_board_mm,
                   "displacement of the last fixed board in the second half of "
                   "the views")
      ->option_text("MM")
      ->check(CLI::Range(0.0, 1e5))
      ->needs(fixed)
      ->capture_default_str();
}

void AddCameraOptions(CLI::App* command, SimulateArguments* arguments) {
  BeginGroup(command, help_group::kModel);
  CLI::Option* const lens = command
                                ->add_option("--lens", arguments->lens,
                                             "simulated camera, listed below")
                                ->option_text("NAME")
                                ->capture_default_str();
  CLI::Option* const size =
      command->add_option("--size", arguments->size, "image size in px")
          ->option_text("WxH")
          ->capture_default_str();
  CLI::Option* const circle =
      command
          ->add_option("--image-circle", arguments->image_circle_px,
                       "radius of the image circle about the image centre; 0: "
                       "none")
          ->option_text("PX")
          ->check(CLI::Range(0.0, 1e6))
          ->capture_default_str();
  command
      ->add_option("--camera", arguments->camera,
                   "camera.yaml or blob instead of --lens, --size and "
                   "--image-circle")
      ->option_text("FILE")
      ->excludes(lens)
      ->excludes(size)
      ->excludes(circle);
  command
      ->add_option("--cameras", arguments->cameras,
                   "number of identical cameras of a rig")
      ->option_text("N")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command
      ->add_option("--baseline-m", arguments->baseline_m,
                   "distance between neighbouring cameras")
      ->option_text("M")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command
      ->add_option("--camera-turn-deg", arguments->camera_turn_deg,
                   "angle between neighbouring cameras, on a circle; 0: in a "
                   "row")
      ->option_text("DEG")
      ->check(CLI::Range(-180.0, 180.0))
      ->capture_default_str();
  AddPatternOption(command, &arguments->pattern,
                   " (default: chessboard:30x24:20mm)");
  AddMultiBoardOptions(command, arguments);
}

void AddMotionOptions(CLI::App* command, SimulateArguments* arguments) {
  BeginGroup(command, "Motion");
  CLI::Option* moving = command->add_flag(
      "--moving", arguments->moving,
      "simulate consecutive video frames of a hand-held target");
  command
      ->add_option("--line-delay-us", arguments->line_delay_us,
                   "rolling-shutter line delay in µs; negative: readout starts "
                   "at the bottom row; 0: global shutter")
      ->option_text("US")
      ->check(CLI::Range(-1000.0, 1000.0))
      ->needs(moving)
      ->capture_default_str();
  command
      ->add_option("--frame-rate", arguments->frames_per_second,
                   "frames per second")
      ->option_text("HZ")
      ->check(CLI::Range(0.1, 10000.0))
      ->needs(moving)
      ->capture_default_str();
  command
      ->add_option(
          "--speed", arguments->motion.speed,
          "relative speed; at 1, the target crosses the image in a few seconds")
      ->option_text("X")
      ->check(CLI::Range(0.0, 100.0))
      ->needs(moving)
      ->capture_default_str();
}

}  // namespace

void AddSimulateOptions(CLI::App* command, SimulateArguments* arguments) {
  AddObservationOptions(command, arguments);
  AddMotionOptions(command, arguments);
  AddCameraOptions(command, arguments);
  AddImagingOptions(command, arguments);
}

}  // namespace raygrid
