#ifndef RAYGRID_SIMULATION_SIMULATED_OBSERVATIONS_H
#define RAYGRID_SIMULATION_SIMULATED_OBSERVATIONS_H

#include <cstdint>
#include <vector>

#include "camera/camera_model.h"
#include "camera/pose.h"
#include "dataset/dataset.h"
#include "simulation/random.h"

namespace raygrid {

struct SimulationOptions {
  int num_images = 100;  ///< of different views
  /// Images of each view, one after the other, with noise of their own.
  int num_shots = 1;
  int features_per_image = 240;  ///< at most; images with fewer are not made
  double noise_px = 0.05;        ///< standard deviation of each coordinate
  /// The board is bent by this much at its edges: a paraboloid.
  double board_bend_m = 0;
  /// Besides, each view has a bend of its own: FlexedBoard().
  double board_flex_m = 0;
  /// Noise that neighbours on the board share, of its own in each image: a
  /// smooth random displacement, standard deviation of each coordinate, and how
  /// many features away it is alike by exp(-1/2).
  double shared_noise_px = 0, shared_noise_features = 8;
  uint64_t seed = 1;
};

struct SimulatedObservations {
  Dataset dataset;
  Pattern true_pattern;  ///< with the points where they really are
  std::vector<BoardPose> poses;
};

/// Exact or noisy observations of the pattern's first board, held all over the
/// field of view, partly beyond its edge, at distances from which it is
/// half as wide as the image to nearly twice as wide, tilted by up to 60
/// degrees. Reproducible on any machine. Throws Error(kTooFew) if images of so
/// many features hardly occur.
SimulatedObservations SimulateObservations(const CameraModel& camera,
                                           const Pattern& pattern,
                                           const SimulationOptions& options);

/// Keeps count of the features, or all, chosen at random, in their order.
void ThinFeatures(size_t count, Random* random, std::vector<Feature>* features);

/// Moves the features of an image at random: each, and all smoothly.
void AddNoise(const SimulationOptions& options, Random* random,
              std::vector<Feature>* features);

/// Features of a board, bent or not, that are seen within the image, exactly.
std::vector<Feature> VisibleFeatures(const CameraModel& camera,
                                     const Board& board, const Pose& pose);

/// The poses in which boards are held to be photographed.
struct PoseOptions {
  /// Width of a square in the image, where the board is not tilted.
  double min_square_px = 12, max_square_px = 30;
  double max_tilt_rad = 50 * M_PI / 180;
  double max_turn_rad = M_PI;  ///< in its plane, either way
};

/// Poses of a board whose point center_m looks out of a random pixel of the
/// image. Reproducible on any machine.
std::vector<Pose> RandomPoses(const CameraModel& camera,
                              const Eigen::Vector3d& center_m, double square_m,
                              int count, const PoseOptions& options,
                              uint64_t seed);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_SIMULATED_OBSERVATIONS_H
