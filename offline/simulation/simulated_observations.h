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
  int num_images = 100;  ///< distinct views
  /// Number of consecutive images of each view, with independent noise.
  int num_shots = 1;
  int features_per_image = 240;  ///< maximum; views with fewer are discarded
  double noise_px = 0.05;        ///< standard deviation of each coordinate
  /// Deflection of the board at its edges: a paraboloid.
  double board_sagitta_m = 0;
  /// Additional per-view deformation, RMS: DeformBoard().
  double board_deformation_m = 0;
  /// Spatially correlated noise, independent in each image: a smooth random
  /// displacement, with the standard deviation of each coordinate and the
  /// distance in features at which the correlation is exp(-1/2).
  double shared_noise_px = 0, shared_noise_features = 8;
  uint64_t seed = 1;
};

struct SimulatedObservations {
  Dataset dataset;
  Pattern true_pattern;  ///< with the true points
  std::vector<BoardPose> poses;
};

/// Simulates exact or noisy observations of the pattern's first board, all over
/// the field of view and partly outside it, at distances from which it is half
/// to nearly twice as wide as the image, tilted by up to 60 degrees.
/// Reproducible on any machine. Throws Error(kInsufficientData) if images with
/// as many features are too rare.
SimulatedObservations SimulateObservations(const CameraModel& camera,
                                           const Pattern& pattern,
                                           const SimulationOptions& options);

/// Keeps count random features in their order, or all if there are fewer.
void SubsampleFeatures(size_t count, Random* random,
                       std::vector<Feature>* features);

/// Adds white and spatially correlated noise to the features of an image.
void AddNoise(const SimulationOptions& options, Random* random,
              std::vector<Feature>* features);

/// Projects the features of a board without noise; omits invisible ones.
std::vector<Feature> VisibleFeatures(const CameraModel& camera,
                                     const Board& board, const Pose& pose);

/// The distribution of board poses.
struct PoseOptions {
  /// Width of a square in the image, without tilt.
  double min_square_px = 12, max_square_px = 30;
  double max_tilt_rad = 50 * M_PI / 180;
  double max_rotation_rad = M_PI;  ///< in-plane rotation, either way
};

/// Draws poses of a board whose point center_m projects to a random pixel of
/// the image. Reproducible on any machine.
std::vector<Pose> RandomPoses(const CameraModel& camera,
                              const Eigen::Vector3d& center_m, double square_m,
                              int count, const PoseOptions& options,
                              uint64_t seed);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_SIMULATED_OBSERVATIONS_H
