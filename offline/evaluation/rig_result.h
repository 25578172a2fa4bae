#ifndef RAYGRID_EVALUATION_RIG_RESULT_H
#define RAYGRID_EVALUATION_RIG_RESULT_H

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "camera/pose.h"
#include "evaluation/board_bodies.h"
#include "evaluation/calibration_result.h"

namespace raygrid {

/// How two cameras of a rig stand to each other.
struct Baseline {
  size_t first = 0, second = 0;  ///< cameras
  int num_shared_views = 0;      ///< of a board at one instant
  double distance_m = 0;         ///< between their centres
  double angle_rad = 0;          ///< of the rotation between them
  /// Standard deviation of the distance, as the residuals and the adjustment
  /// make it, and the RMS angle by which the rotation may be off.
  std::optional<double> distance_sd_m, rotation_sd_rad;
};

/// Two cameras whose relative pose may be a turn of a board off, since all
/// views that they share agree with both.
struct AmbiguousPair {
  size_t first = 0, second = 0;
  int num_shared_views = 0;
};

/// The result of calibrating the cameras of a rig, or a single one. Each
/// camera's held-out residuals are those of images localised alone.
struct RigResult {
  std::vector<CalibrationResult> cameras;
  std::vector<Pose> camera_from_rig;  ///< the first camera's frame is the rig's
  Pattern pattern;                    ///< points where they were found to be
  std::vector<Baseline> baselines;    ///< of every two cameras
  std::vector<BoardPair> board_pairs;  ///< that were seen together often enough
  std::vector<BoardBody> bodies;
  std::vector<AmbiguousPair> ambiguous_pairs;
  /// The held-out residuals by camera, with each board localised once for an
  /// instant by all cameras that see it: what the cameras' poses are worth.
  std::vector<std::vector<FeatureResidual>> held_out;
  bool cross_validated = false;
  bool converged = false;
  Verdict verdict;
  std::map<std::string, double> seconds;  ///< by stage, of all cameras together

  bool IsRig() const { return cameras.size() > 1; }
};

/// Distances and angles; without standard deviations and views.
std::vector<Baseline> ComputeBaselines(
    const std::vector<Pose>& camera_from_rig);

/// Residuals of all cameras as one.
ErrorFigures TrainingFigures(const RigResult& result);
std::optional<ErrorFigures> HeldOutFigures(const RigResult& result);

/// The worst of the cameras' verdicts, and what the rig adds; a single camera's
/// own.
Verdict JudgeRig(const RigResult& result);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_RIG_RESULT_H
