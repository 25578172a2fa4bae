#include <algorithm>
#include <cmath>

#include "adjustment/view_jacobian.h"
#include "calibration/target_localization.h"
#include "hand_eye/hand_eye_calibration.h"
#include "hand_eye/hand_eye_diagnosis.h"
#include "hand_eye/hand_eye_file.h"
#include "hand_eye/hand_eye_input.h"
#include "hand_eye/simulated_robot.h"
#include "simulation/simulated_observations.h"
#include "test_boards.h"

namespace raygrid {
namespace {

constexpr Mounting kMountings[] = {Mounting::kEyeInHand, Mounting::kEyeToHand};

SimulatedRobotOptions RobotWith(Mounting mounting) {
  SimulatedRobotOptions options;
  options.mounting = mounting;
  return options;
}

template <typename Function>
std::string ErrorOfCall(const Function& function, ExitCode code) {
  try {
    function();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return "";
}

#define EXPECT_HAS(text, part) \
  EXPECT_NE((text).find(part), std::string::npos) << (text)

TEST(HandEye, JacobiansAreThoseOfDifferences) {
  for (const Mounting mounting : kMountings) {
    const SimulatedRobot robot = SimulateRobot(RobotWith(mounting), 1);
    const HandEyeObservation& observation = robot.observations[3];
    const LinearizedHandEye linear =
        LinearizeHandEye(robot.truth, mounting, observation);
    const auto predict = [&](const Eigen::VectorXd& update) {
      const HandEye moved = {
          UpdatedPose(robot.truth.camera_from_mount, update.segment<6>(0)),
          UpdatedPose(robot.truth.anchor_from_target, update.segment<6>(6))};
      Pose base =
          UpdatedPose(observation.base_from_gripper, update.segment<6>(12));
      base.translation +=
          update[18] * observation.base_from_gripper.translation;
      return Eigen::VectorXd(
          PoseDifference(PredictTargetPose(robot.truth, mounting,
                                           observation.base_from_gripper),
                         PredictTargetPose(moved, mounting, base)));
    };
    Eigen::Matrix<double, 6, 19> J;
    J << linear.J_hand_eye, linear.J_rotation, linear.J_translation,
        linear.J_scale;
    EXPECT_LT(
        RelativeDifference(
            CentralDifference(predict, Eigen::VectorXd::Zero(19), 1e-6), J),
        1e-6);
  }
}

TEST(HandEye, AnExactRobotIsSolvedLinearly) {
  for (const Mounting mounting : kMountings) {
    SimulatedRobotOptions options = RobotWith(mounting);
    options.noise = {0, 0};
    options.camera_rad = options.camera_m = 1e-9;
    options.num_poses = 4;
    const SimulatedRobot robot = SimulateRobot(options, 2);
    const auto found =
        SolveLinearHandEye(robot.observations, mounting, {0, 1, 2, 3});
    ASSERT_TRUE(found);
    EXPECT_LT(ErrorOf(*found, robot.truth).norm(), 1e-6);
  }
}

// The stated covariance is that of the errors, with noise that is estimated.
TEST(HandEye, CovarianceIsThatOfTheErrors) {
  constexpr int kRobots = 60;
  for (const Mounting mounting : kMountings) {
    const SimulatedRobotOptions options = RobotWith(mounting);
    double sum = 0, turns = 0, shifts = 0, held_out_mm = 0;
    for (int seed = 1; seed <= kRobots; ++seed) {
      const SimulatedRobot robot = SimulateRobot(options, seed);
      const HandEyeResult result =
          CalibrateHandEye(robot.observations, mounting, {});
      EXPECT_TRUE(result.fit.converged);
      EXPECT_EQ(result.NumUsed(), options.num_poses);
      const Vector12d error = ErrorOf(result.fit.hand_eye, robot.truth);
      sum += error.dot(*InvertScaled(result.fit.covariance) * error) / 12;
      turns += std::pow(
          result.fit.noise.rotation_rad / options.noise.rotation_rad, 2);
      shifts += std::pow(
          result.fit.noise.translation_m / options.noise.translation_m, 2);
      held_out_mm += 1000 * result.held_out.rms.translation_m;
    }
    // Estimated variances make it a little larger than 1.
    EXPECT_NEAR(sum / kRobots, 1.05, 0.2);
    EXPECT_NEAR(turns / kRobots, 1, 0.15);
    EXPECT_NEAR(shifts / kRobots, 1, 0.15);
    EXPECT_NEAR(held_out_mm / kRobots, 1, 0.5);
  }
}

TEST(HandEye, WrongPosesAreNamed) {
  const SimulatedRobotOptions options;
  SimulatedRobot robot = SimulateRobot(options, 5);
  auto& poses = robot.observations;
  std::swap(poses[2].base_from_gripper, poses[11].base_from_gripper);
  poses[7].base_from_gripper.translation.x() += 0.01;
  poses[13].base_from_gripper = poses[14].base_from_gripper;
  const HandEyeResult result = CalibrateHandEye(poses, options.mounting, {});
  for (int k = 0; k < options.num_poses; ++k)
    EXPECT_EQ(result.poses[k].is_used, k != 2 && k != 7 && k != 11 && k != 13)
        << k;
  EXPECT_HAS(result.poses[2].reason, "swapped with that of im11.png");
  EXPECT_HAS(result.poses[11].reason, "swapped with that of im2.png");
  EXPECT_HAS(result.poses[7].reason, "does not fit");
  const Vector12d error = ErrorOf(result.fit.hand_eye, robot.truth);
  EXPECT_LT(error.dot(*InvertScaled(result.fit.covariance) * error) / 12, 3);
}

TEST(HandEye, MissingMotionIsNamed) {
  for (const Mounting mounting : kMountings) {
    SimulatedRobotOptions options = RobotWith(mounting);
    options.tilt_rad = 1e-4;
    const auto one_axis = [&] {
      CalibrateHandEye(SimulateRobot(options, 6).observations, mounting, {});
    };
    EXPECT_HAS(ErrorOfCall(one_axis, ExitCode::kInitializationFailed),
               "about one axis only");
    options.turn_rad = 1e-4;
    EXPECT_HAS(ErrorOfCall(one_axis, ExitCode::kInitializationFailed),
               "does not rotate");
  }
  const SimulatedRobot robot = SimulateRobot({}, 6);
  EXPECT_HAS(ErrorOfCall(
                 [&] {
                   CalibrateHandEye({robot.observations.begin(),
                                     robot.observations.begin() + 2},
                                    Mounting::kEyeInHand, {});
                 },
                 ExitCode::kInsufficientData),
             "2 of at least 3 poses");
}

TEST(HandEye, OtherConventionsAreRecognized) {
  const Mounting mounting = Mounting::kEyeInHand;
  const auto error_with = [&](const auto& change) {
    SimulatedRobot robot = SimulateRobot({}, 8);
    change(&robot.observations);
    return ErrorOfCall(
        [&] { CalibrateHandEye(robot.observations, mounting, {}); },
        ExitCode::kInitializationFailed);
  };
  EXPECT_HAS(error_with([](auto* poses) {
               for (auto& pose : *poses)
                 pose.base_from_gripper = pose.base_from_gripper.Inverse();
             }),
             "if they are inverted");
  EXPECT_HAS(error_with([](auto* poses) {
               for (auto& pose : *poses) {
                 Eigen::Quaterniond& q = pose.base_from_gripper.rotation;
                 q = Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y());
               }
             }),
             "w x y z");
  EXPECT_HAS(error_with([](auto* poses) {
               for (size_t k = poses->size(); --k > 0;)
                 (*poses)[k].base_from_gripper =
                     (*poses)[k - 1].base_from_gripper;
             }),
             "the next one");
}

TEST(HandEye, OtherUnitsAreRecognized) {
  SimulatedRobot robot = SimulateRobot({}, 9);
  RequireSameUnit(robot.observations, Mounting::kEyeInHand);
  for (auto& pose : robot.observations)
    pose.base_from_gripper.translation *= 1000;
  const auto check = [&] {
    RequireSameUnit(robot.observations, Mounting::kEyeInHand);
  };
  EXPECT_HAS(ErrorOfCall(check, ExitCode::kInvalidInput), "--robot-unit mm");
  for (auto& pose : robot.observations)
    pose.base_from_gripper.translation *= 1e-6;
  EXPECT_HAS(ErrorOfCall(check, ExitCode::kInvalidInput), "--robot-unit m,");
}

TEST(HandEye, ScaleErrorsAndOptimismAreReported) {
  SimulatedRobot robot = SimulateRobot({}, 10);
  for (auto& pose : robot.observations)
    pose.base_from_gripper.translation *= 1.01;
  HandEyeResult result =
      CalibrateHandEye(robot.observations, Mounting::kEyeInHand, {});
  EXPECT_NEAR(result.scale->value, 0.01, 5 * result.scale->stddev + 1e-3);
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_HAS(result.warnings[0], "lengths of the robot");
  result = CalibrateHandEye(SimulateRobot({}, 11).observations,
                            Mounting::kEyeInHand, {1e-4, 3e-5});
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_HAS(result.warnings[0], "stated robot accuracy");
}

TEST(HandEye, TheSuggestedPoseHelpsAsPredicted) {
  SimulatedRobotOptions options;
  options.tilt_rad = 0.05;  // nearly one axis
  SimulatedRobot robot = SimulateRobot(options, 12);
  const HandEyeResult before =
      CalibrateHandEye(robot.observations, options.mounting, {});
  ASSERT_TRUE(before.suggestion);
  const SuggestedPose& next = *before.suggestion;
  EXPECT_LT(next.new_translation_stddev_m, 0.7 * next.translation_stddev_m);
  HandEyeObservation added = robot.observations[0];
  added.base_from_gripper = next.base_from_gripper;
  added.camera_from_target = PredictTargetPose(
      before.fit.hand_eye, options.mounting, next.base_from_gripper);
  robot.observations.push_back(added);
  const HandEyeResult after = CalibrateHandEye(
      robot.observations, options.mounting,
      {before.fit.noise.rotation_rad, before.fit.noise.translation_m});
  EXPECT_NEAR(
      ListTransforms(after.fit, options.mounting)[0].TranslationStdDev() /
          next.new_translation_stddev_m,
      1, 0.1);
}

// From a target tilted by 55 degrees, a rotation by 90 degrees leads behind it.
TEST(HandEye, TheSuggestedPoseShowsTheFrontOfTheTarget) {
  SimulatedRobotOptions options;
  options.tilt_rad = 0.1;
  options.common_tilt_rad = 55 * M_PI / 180;
  for (int seed = 1; seed <= 8; ++seed) {
    const SimulatedRobot robot = SimulateRobot(options, seed);
    const HandEyeResult result =
        CalibrateHandEye(robot.observations, options.mounting, {});
    ASSERT_TRUE(result.suggestion);
    const auto side = [](const Pose& camera_from_target) {
      return (camera_from_target.rotation * Eigen::Vector3d::UnitZ())
          .dot(camera_from_target.translation);
    };
    EXPECT_GT(side(PredictTargetPose(result.fit.hand_eye, options.mounting,
                                     result.suggestion->base_from_gripper)) *
                  side(robot.observations[0].camera_from_target),
              0)
        << seed;
  }
}

// ---- Reprojection errors ---------------------------------------------------

// Gauss-Newton equations of the joint problem: both transformations and one
// robot pose per image, whose prior is the pose that the robot reported, and
// the reprojection errors of all features. Robot poses are eliminated.
struct JointProblem {
  Matrix12d H = Matrix12d::Zero();
  Vector12d b = Vector12d::Zero();
};

// Adds an image at a robot pose; returns the update of the robot pose for
// unchanged transformations.
Vector6d AddImage(const AdjustmentState& state, const View& view,
                  const HandEye& hand_eye, Mounting mounting,
                  const HandEyeObservation& observation, const Pose& robot,
                  const RobotNoise& noise, JointProblem* joint) {
  HandEyeObservation at = observation;
  at.base_from_gripper = robot;
  const LinearizedHandEye linear = LinearizeHandEye(hand_eye, mounting, at);
  PoseCovariance H_pose = PoseCovariance::Zero();
  Vector6d b_pose = Vector6d::Zero();
  for (const LinearizedResidual& residual : LinearizeView(state, view)) {
    H_pose += residual.J_pose.transpose() * residual.J_pose;
    b_pose -= residual.J_pose.transpose() * residual.residual.error_px;
  }
  H_pose /= observation.feature_variance;
  b_pose /= observation.feature_variance;
  PoseCovariance J_robot, precision = PoseCovariance::Zero();
  J_robot << linear.J_rotation, linear.J_translation;
  precision.diagonal().head<3>().setConstant(std::pow(noise.rotation_rad, -2));
  precision.diagonal().tail<3>().setConstant(std::pow(noise.translation_m, -2));
  const PoseCovariance H_robot =
      J_robot.transpose() * H_pose * J_robot + precision;
  const Vector6d b_robot =
      J_robot.transpose() * b_pose +
      precision * PoseDifference(robot, observation.base_from_gripper);
  const Eigen::Matrix<double, 12, 6> cross =
      linear.J_hand_eye.transpose() * H_pose * J_robot;
  const auto solver = H_robot.ldlt();
  joint->H += linear.J_hand_eye.transpose() * H_pose * linear.J_hand_eye -
              cross * solver.solve(cross.transpose());
  joint->b +=
      linear.J_hand_eye.transpose() * b_pose - cross * solver.solve(b_robot);
  return solver.solve(b_robot);
}

// The poses with covariances have the same minimum as the reprojection errors:
// a step of the joint problem from it is small against standard deviations.
TEST(HandEye, PosesAreEquivalentToReprojectionErrors) {
  const Mounting mounting = Mounting::kEyeInHand;
  const OpenCvModel camera = ExampleLens();
  const Pattern pattern = TestBoard();
  SimulationOptions views;
  views.num_images = 15;
  views.features_per_image = 60;
  views.noise_px = 0.3;
  const SimulatedObservations seen =
      SimulateObservations(camera, pattern, views);
  const RigModel rig = {{&camera}, {Pose()}};
  const TargetLocalization localized =
      LocalizeTargets(rig, {seen.dataset}, pattern, 1);

  const RobotNoise noise = {0.1 * M_PI / 180, 0.5e-3};
  TestRandom random(3);
  const HandEye truth = {RandomPose(0.1, &random), RandomPose(0.8, &random)};
  std::map<std::string, Pose> robot;
  for (const BoardPose& pose : seen.poses) {
    Vector6d error;
    error << noise.rotation_rad * random.NormalVector<3>(),
        noise.translation_m * random.NormalVector<3>();
    robot[pose.image] = UpdatedPose(
        MountFromAnchor(mounting, truth.camera_from_mount.Inverse() *
                                      pose.camera_from_board *
                                      truth.anchor_from_target.Inverse()),
        error);
  }
  const std::vector<HandEyeObservation> observations =
      MakeHandEyeObservations(localized.poses, robot);
  const HandEyeResult result = CalibrateHandEye(
      observations, mounting, {noise.rotation_rad, noise.translation_m});
  ASSERT_EQ(result.NumUsed(), 15);

  std::vector<RejectedImage> rejected;
  const CalibrationProblem problem =
      BuildProblem({seen.dataset}, pattern, &rejected);
  std::vector<Pose> true_robot;
  for (const auto& observation : observations)
    true_robot.push_back(observation.base_from_gripper);
  const auto state_at = [&](const Pose& robot_pose) {
    AdjustmentState state;
    state.SetCamera(camera);
    state.points = problem.nominal;
    state.rig_from_pattern = {
        PredictTargetPose(result.fit.hand_eye, mounting, robot_pose)};
    return state;
  };
  // Errors in pixels follow from the covariances.
  for (size_t k = 0; k < observations.size(); ++k) {
    View view = problem.views[k];
    view.pose = 0;
    double sum = 0;
    const std::vector<Residual> residuals = ComputeResiduals(
        state_at(observations[k].base_from_gripper), {view}, 1);
    for (const Residual& residual : residuals)
      sum += residual.error_px.squaredNorm();
    EXPECT_NEAR(std::sqrt(sum / static_cast<double>(residuals.size())) /
                    result.poses[k].residual.rms_px,
                1, 0.1);
  }
  JointProblem joint;
  // The robot poses first move to their optimum.
  for (int round = 0; round < 4; ++round) {
    joint = {};
    for (size_t k = 0; k < observations.size(); ++k) {
      ASSERT_EQ(problem.images[k], observations[k].image);
      View view = problem.views[k];
      view.pose = 0;
      const AdjustmentState state = state_at(true_robot[k]);
      true_robot[k] =
          UpdatedPose(true_robot[k],
                      AddImage(state, view, result.fit.hand_eye, mounting,
                               observations[k], true_robot[k], noise, &joint));
    }
  }
  const Vector12d step = *InvertScaled(joint.H) * joint.b;
  for (int k = 0; k < 12; ++k)
    EXPECT_LT(std::abs(step[k]) / std::sqrt(result.fit.covariance(k, k)), 0.1)
        << k;
  EXPECT_LT(RelativeDifference(*InvertScaled(joint.H), result.fit.covariance),
            0.05);
}

}  // namespace
}  // namespace raygrid
