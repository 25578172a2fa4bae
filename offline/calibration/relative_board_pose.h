#ifndef RAYGRID_CALIBRATION_RELATIVE_BOARD_POSE_H
#define RAYGRID_CALIBRATION_RELATIVE_BOARD_POSE_H

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "adjustment/linear_response.h"
#include "calibration/model_adjustment.h"

namespace raygrid {

/// How one board stands to another at one instant: the second in the frame of
/// the first.
struct RelativeBoardPose {
  static constexpr int kDimensions = 6;
  using Vector = Eigen::Matrix<double, 6, 1>;
  using Matrix = Eigen::Matrix<double, 6, 6>;

  std::string image;
  int first_pose = 0, second_pose = 0;
  Pose rig_from_first;
  Eigen::Quaterniond turn;
  Eigen::Vector3d middle;           ///< of the second board
  Vector J_scale = Vector::Zero();  ///< of the second board, if it is free
  /// Of turn and middle, by UpdatedPose()'s updates.
  Matrix J_first = Matrix::Zero(), J_second = Matrix::Zero();
  Matrix covariance = Matrix::Zero(), information = Matrix::Zero();
};

/// The second board's place on the average; how much larger than the second's
/// own scale that of the first is.
struct MeanRelativePose {
  Eigen::Quaterniond turn;
  Eigen::Vector3d middle;
  double scale = 0;
};

/// A squared deviation in units of its variance beyond which a relation is far
/// off: 99.9 % of chi-square with six degrees of freedom, times two, since
/// covariances are no more than roughly known. A grid that is too coarse for
/// its lens adds to them.
constexpr double kRoughly = 2, kMaxSquaredMahalanobis = kRoughly * 22.458;

RelativeBoardPose::Vector ComputeDeviation(const MeanRelativePose& mean,
                                           const RelativeBoardPose& relation);
double SquaredMahalanobis(const MeanRelativePose& mean,
                          const RelativeBoardPose& relation);

/// The mean by the relations' information; those that are far off count less.
MeanRelativePose ComputeRobustMean(
    const std::vector<RelativeBoardPose>& relations);

/// Relations that hardly tell how the boards are turned leave: one row of a
/// board leaves its turn around the row open, and a start may be anywhere.
void RemoveUndetermined(std::vector<RelativeBoardPose>* relations);

/// The relations of two boards in an adjustment, without covariances; evenly
/// chosen where they are too many.
/// @param middle of the second board, in its frame
std::vector<RelativeBoardPose> ComputeRelativePoses(
    const AdjustmentResult& adjusted, int first, int second,
    const Eigen::Vector3d& middle, size_t max_count);

/// How well an adjustment's poses are known: besides noise, the camera and the
/// points may be off, and all their priors may hold.
class PoseEquations {
 public:
  PoseEquations(const AdjustmentResult& adjusted, const Pattern& pattern,
                int num_threads);

  /// How many relations of two poses can be afforded.
  size_t MaxNumRelations() const { return response_.IsExact() ? 60 : 16; }

  /// The covariances of relations. Errors that neighbours still share are no
  /// smaller for the number of features: those of n count as if each was n / 3
  /// times as large. False if the equations are singular.
  bool AddCovariances(std::vector<RelativeBoardPose>* relations) const;

 private:
  LinearResponse response_;
  double variance_, correlation_ = 0;
  std::vector<double> num_features_;  // of each pose
};

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_RELATIVE_BOARD_POSE_H
