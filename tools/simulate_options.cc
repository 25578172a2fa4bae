#include "simulate_options.h"

#include "pattern_input.h"

namespace raygrid {
namespace {

void AddObservationOptions(CLI::App* command, SimulateArguments* arguments) {
  SimulationOptions& simulation = arguments->simulation;
  command->add_option("--images", simulation.num_images, "number of views")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command
      ->add_option("--repeats", simulation.num_shots,
                   "images of each view, which differ by noise")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command
      ->add_option("--features-per-image", arguments->features_per_image,
                   "features in each, without --render (default: 240, or all "
                   "that the board has)")
      ->check(CLI::Range(1, 1000000));
  command
      ->add_option("--noise-px", simulation.noise_px,
                   "standard deviation of each coordinate, without --render")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command
      ->add_option("--correlated-noise-px", simulation.shared_noise_px,
                   "noise that neighbours on the board share, besides, without "
                   "--render: standard deviation of each coordinate")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command
      ->add_option("--correlation-length", simulation.shared_noise_features,
                   "how many features away it is alike, by exp(-1/2)")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  command
      ->add_option("--target-deformation-mm", arguments->board_bend_mm,
                   "how far the board's edges are bent out of its plane")
      ->check(CLI::Range(-1000.0, 1000.0))
      ->capture_default_str();
  command
      ->add_option("--per-view-deformation-mm", arguments->board_flex_mm,
                   "each view bends the board besides, at random and "
                   "smoothly: standard deviation of its features' heights, "
                   "without --render")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
}

void AddImagingOptions(CLI::App* command, SimulateArguments* arguments) {
  ImagingOptions& imaging = arguments->imaging;
  const auto add = [command](const char* name, double& value,
                             const char* description, double low, double high) {
    command->add_option(name, value, description)
        ->check(CLI::Range(low, high))
        ->capture_default_str();
  };
  command->add_flag("--render", arguments->render,
                    "images too: their exact features in features.csv");
  add("--blur-px", imaging.blur_px, "the lens's blur, standard deviation", 0,
      50);
  add("--read-noise", imaging.read_noise, "standard deviation, grey levels", 0,
      255);
  add("--shot-noise", imaging.shot_noise, "variance per grey level", 0, 255);
  add("--vignetting", imaging.vignetting, "part of the light lost in corners",
      0, 0.99);
  add("--gamma", imaging.gamma, "of the stored levels", 0.1, 10);
  add("--exposure", imaging.exposure, "multiplies all levels", 0.01, 100);
  add("--max-tilt-deg", arguments->max_tilt_deg, "of rendered boards", 0, 80);
  add("--min-square-px", arguments->poses.min_square_px,
      "a square's width in rendered images, at least", 1, 1000);
  add("--max-square-px", arguments->poses.max_square_px, "at most", 1, 1000);
  command
      ->add_option("--samples-per-pixel", imaging.samples_per_pixel,
                   "along each axis")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command->add_option("--bits", arguments->bits, "8 or 16, of the images")
      ->check(CLI::IsMember({8, 16}))
      ->capture_default_str();
}

void AddCameraOptions(CLI::App* command, SimulateArguments* arguments) {
  AddPatternOption(command, &arguments->pattern,
                   "; default: a chessboard. Several boards are rendered side "
                   "by side; without --render the first is observed");
  CLI::Option* const lens =
      command
          ->add_option("--lens", arguments->lens,
                       "pinhole, example, wide, fisheye, fisheye190, "
                       "noncentral, glass; without an axis of symmetry: "
                       "anamorphic, off-axis, halves, decentred, mirror; "
                       "changing with --at: focusing (0 to 10 dioptres; 0 if "
                       "it is not told), warming (20 to 70 °C; 20), "
                       "focusing-warming")
          ->capture_default_str();
  CLI::Option* const size =
      command->add_option("--size", arguments->size, "of images, WxH")
          ->capture_default_str();
  CLI::Option* const circle =
      command
          ->add_option("--image-circle", arguments->image_circle_px,
                       "pixels around the image's middle, beyond which the "
                       "lens throws no light; 0: all is lit")
          ->check(CLI::Range(0.0, 1e6))
          ->capture_default_str();
  command
      ->add_option("--camera", arguments->camera,
                   "camera.yaml or blob, instead of --lens, --size and "
                   "--image-circle")
      ->excludes(lens)
      ->excludes(size)
      ->excludes(circle);
  command
      ->add_option("--cameras", arguments->cameras,
                   "of one kind on a rig, in a row, cam0 first; each image "
                   "shows what its camera sees, at most --features-per-image "
                   "of each board")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command
      ->add_option("--baseline-m", arguments->baseline_m,
                   "between neighbouring cameras")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  CLI::Option* fixed = command->add_flag(
      "--fixed-boards", arguments->fixed_boards,
      "all boards of the pattern are fixed to each other, side by side, and "
      "move as one; otherwise each moves by itself");
  command
      ->add_option("--board-gap-m", arguments->fixed.gap_m,
                   "between fixed boards")
      ->check(CLI::Range(0.0, 100.0))
      ->needs(fixed)
      ->capture_default_str();
  command
      ->add_option("--board-turn-deg", arguments->board_turn_deg,
                   "of each fixed board against the one before it")
      ->check(CLI::Range(-180.0, 180.0))
      ->needs(fixed)
      ->capture_default_str();
  command
      ->add_flag("--no-common-boards", arguments->fixed.never_shared,
                 "no two cameras see one of the fixed boards at one instant: "
                 "what the first of them sees is hidden from the others")
      ->needs(fixed);
  command
      ->add_option("--move-board-mm", arguments->move_board_mm,
                   "how far the last of the fixed boards is moved after half "
                   "of the views")
      ->check(CLI::Range(0.0, 1e5))
      ->needs(fixed)
      ->capture_default_str();
}

void AddMotionOptions(CLI::App* command, SimulateArguments* arguments) {
  CLI::Option* moving = command->add_flag(
      "--moving", arguments->moving,
      "--images are consecutive frames of a board in a hand that moves");
  command
      ->add_option("--line-delay-us", arguments->row_time_us,
                   "how much later than the row above it a row is read; "
                   "negative: from the last one on; 0: a global shutter")
      ->check(CLI::Range(-1000.0, 1000.0))
      ->needs(moving)
      ->capture_default_str();
  command
      ->add_option("--frame-rate", arguments->frames_per_second,
                   "frames a second")
      ->check(CLI::Range(0.1, 10000.0))
      ->needs(moving)
      ->capture_default_str();
  command
      ->add_option("--speed", arguments->motion.speed,
                   "of the hand: 1 takes some seconds from one side of the "
                   "image to the other; 0 keeps still")
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
