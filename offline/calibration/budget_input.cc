#include "calibration/budget_input.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "adjustment/deformation_modes.h"
#include "adjustment/reprojection_error.h"
#include "calibration/calibration_problem.h"
#include "calibration/camera_evaluation.h"

namespace raygrid {
namespace {

using PosesByBoard = std::map<std::pair<std::string, int>, Pose>;

// Adds the points of all boards, in sequence, and their deformation modes.
void AddPoints(const Pattern& pattern, BudgetInput* input,
               std::map<int, int>* first_point_by_board) {
  std::vector<BoardPoints> boards;
  for (const Board& board : pattern.boards) {
    const int first = static_cast<int>(input->points.size());
    (*first_point_by_board)[board.id] = first;
    boards.push_back({first, board.points});
    input->boards.insert(input->boards.end(), board.points.size(),
                         static_cast<int>(boards.size()) - 1);
    input->points.insert(input->points.end(), board.points.begin(),
                         board.points.end());
  }
  const DeformationModes modes =
      MakeDeformationModes(boards, static_cast<int>(input->points.size()));
  if (modes.count() == 0) return;
  for (const DeformationModes::Displacement& displacement : modes.by_point)
    input->bends.emplace_back(displacement);
}

// Computes the Jacobians of a residual with respect to its point and to the
// board pose. Returns false if the camera cannot project the point.
bool AddJacobians(const CameraModel& camera, const Pose& camera_from_board,
                  const Eigen::Vector3d& point, BudgetFeature* feature) {
  LinearizedProjection projection;
  const Eigen::Vector3d seen = camera_from_board * point;
  if (!camera.Linearize(seen, &feature->pixel, kAdjustmentMarginPx,
                        &projection))
    return false;
  const Eigen::Vector3d turned = seen - camera_from_board.translation;
  Eigen::Matrix3d J_rotation;                // Jacobian of rotation x turned
  J_rotation << 0, turned.z(), -turned.y(),  //
      -turned.z(), 0, turned.x(),            //
      turned.y(), -turned.x(), 0;
  feature->J_point =
      projection.J_point * camera_from_board.rotation.toRotationMatrix();
  feature->J_pose << projection.J_point * J_rotation, projection.J_point;
  return feature->J_point.allFinite() && feature->error_px.allFinite();
}

BudgetInput JoinResiduals(const CameraModel& camera, const Pattern& pattern,
                          const PosesByBoard& poses,
                          const std::vector<FeatureResidual>& residuals) {
  BudgetInput input;
  input.image_size = camera.image_size();
  std::map<int, int> first_point_by_board;
  AddPoints(pattern, &input, &first_point_by_board);
  // The input requires residuals grouped by view and views sorted by time.
  std::map<std::pair<std::string, int>, std::vector<const FeatureResidual*>>
      views;
  for (const FeatureResidual& residual : residuals)
    views[{residual.image, residual.board}].push_back(&residual);
  int view = 0;
  for (const auto& [name, own] : views) {
    const auto pose = poses.find(name);
    const Board* board = pattern.FindBoard(name.second);
    if (pose == poses.end() || !board) continue;
    const size_t before = input.features.size();
    for (const FeatureResidual* residual : own) {
      BudgetFeature feature;
      feature.view = view;
      feature.point = first_point_by_board.at(board->id) +
                      board->PointIndex(residual->column, residual->row);
      feature.column = residual->column;
      feature.row = residual->row;
      feature.pixel = residual->pixel;
      feature.error_px = residual->error_px;
      if (AddJacobians(camera, pose->second, input.points[feature.point],
                       &feature))
        input.features.push_back(feature);
    }
    if (input.features.size() > before) ++view;
  }
  return input;
}

}  // namespace

BudgetInput MakeBudgetInput(const CalibrationResult& result,
                            const BudgetSummary& facts) {
  PosesByBoard poses;
  for (const BoardPose& pose : result.poses)
    poses[{pose.image, pose.board}] = pose.camera_from_board;
  BudgetInput input = JoinResiduals(*result.camera.camera, result.pattern,
                                    poses, result.training);
  input.num_parameters = result.num_parameters;
  input.facts = facts;
  return input;
}

BudgetSummary MakeBudgetSummary(const CalibrationResult& result,
                                const CalibrationOptions& options) {
  BudgetSummary facts;
  facts.model = options.model;
  facts.knot_spacing_px = result.knot_spacing_px;
  facts.knot_spacing_selected = result.knot_spacing_candidates.size() > 1;
  facts.has_tried_finer_grid =
      std::any_of(result.knot_spacing_candidates.begin(),
                  result.knot_spacing_candidates.end(), [&](const auto& tried) {
                    return tried.knot_spacing_px < result.knot_spacing_px;
                  });
  facts.has_estimated_points = !options.fix_target_geometry;
  facts.has_tried_deformation =
      facts.IsGrid() && !options.fix_target_geometry && !options.rigid_board;
  return facts;
}

BudgetInput MakeBudgetInput(const CameraModel& camera, const Dataset& dataset,
                            const Pattern& pattern, int num_threads) {
  Evaluation evaluation;
  const CalibrationProblem problem =
      BuildProblem({dataset}, pattern, &evaluation.rejected_images);
  const auto localized = LocalizeViews(camera, 0, problem, num_threads);
  PosesByBoard poses;
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    if (!localized[v]) continue;
    poses[{problem.images[v], pattern.boards[problem.boards[v]].id}] =
        *localized[v];
    AddResiduals(camera, *localized[v], pattern, problem, v, &evaluation);
  }
  BudgetInput input =
      JoinResiduals(camera, pattern, poses, evaluation.residuals);
  input.facts.model = camera.Name();
  return input;
}

}  // namespace raygrid
