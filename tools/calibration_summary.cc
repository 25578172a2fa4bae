#include "calibration_summary.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "dataset/fixed_operating_point.h"
#include "dataset/text_encoding.h"
#include "evaluation/board_flatness.h"
#include "evaluation/budget_assessment.h"
#include "evaluation/line_delay_text.h"
#include "evaluation/operating_point_change.h"
#include "evaluation/rounded_text.h"
#include "report/result_json.h"

namespace raygrid {
namespace {

void PrintMetrics(const char* name, const ErrorMetrics& metrics) {
  fmt::print(
      "  {:<9} median {:.3g} px, RMS {:.3g} px, max {:.3g} px, {} features\n",
      name, metrics.median_px, metrics.rms_px, metrics.max_px, metrics.count);
}

// Prints the first line of a camera, after its model's name.
void PrintSize(const CalibrationResult& result) {
  if (result.has_known_intrinsics)
    fmt::print("known intrinsics");
  else
    fmt::print("{} parameters", result.num_parameters);
  fmt::print(", {} images", result.features.images.size());
  if (result.knot_spacing_px > 0)
    fmt::print(", knot spacing {:.0f} px", result.knot_spacing_px);
  fmt::print("\n");
}

// Prints the rejected images, by reason.
void PrintUnusedImages(const CalibrationResult& result) {
  constexpr size_t kMaxNames = 20;
  std::map<std::string, std::vector<std::string>> names;
  for (const RejectedImage& image : result.rejected_images)
    names[image.reason].push_back(image.image);
  for (auto& [reason, images] : names) {
    const size_t count = images.size();
    images.resize(std::min(count, kMaxNames));
    fmt::print("  rejected: {}{} ({})\n",
               Printable(fmt::format("{}", fmt::join(images, ", "))),
               count > kMaxNames
                   ? fmt::format(" and {} more", count - kMaxNames)
                   : std::string(),
               Printable(reason));
  }
}

// Prints the training errors, the number of features without one, and held-out
// errors.
void PrintErrors(const CalibrationResult& result) {
  PrintMetrics("training", *result.camera.training);
  if (const size_t count = CountMissingErrors(result))
    fmt::print("            {} more features are outside the model's domain\n",
               count);
  if (result.camera.held_out) PrintMetrics("held out", *result.camera.held_out);
  if (result.held_out_deformed)
    PrintMetrics("held out with per-view deformation",
                 *result.held_out_deformed);
  if (result.bends)
    fmt::print("  per-view target deformation: {:.3f} mm RMS\n",
               1e3 * result.bends->rms_m);
}

void PrintUncertainty(const CameraUncertainty& uncertainty,
                      const CameraModel& camera) {
  const UncertaintySummary summary = SummarizeUncertainty(camera, uncertainty);
  fmt::print("  predicted uncertainty below");
  for (const double px : kShareLimitsPx) fmt::print("{:>6g}", px);
  fmt::print(" px\n                  in % of image");
  for (const double share : summary.share_below)
    fmt::print("{:>6.0f}", 100 * share);
  fmt::print("\n  {}\n", DescribeUncertainty(summary, uncertainty, camera));
}

void PrintKnownOverRanges(const CameraFile& file) {
  if (const auto known = ComputeMaxUncertainty(file))
    fmt::print(
        "  at the centre of the range; over the whole range: median {:.2g} px, "
        "valid region {:.0f} % of the image\n",
        known->lattice.MedianPx(),
        100 * ComputeValidShare(*file.camera, known->mask));
}

// Prints how the intrinsics change over each of the ranges.
void PrintOperatingPointModel(const OperatingPointModel& stack) {
  for (size_t r = 0; r < stack.ranges().size(); ++r) {
    const std::vector<OperatingPointChange> ends =
        MeasureOperatingPointChanges(stack.SliceAlong(r), 2);
    const Eigen::Vector2d moved = ends[1].center_px - ends[0].center_px;
    fmt::print(
        "  {}: image scale changes by {:.2f} %, image centre by {:.2f} px; "
        "polynomial order {}\n",
        stack.ranges()[r].Text(),
        100 * ((1 + ends[1].growth) / (1 + ends[0].growth) - 1), moved.norm(),
        stack.orders()[r]);
  }
}

// Prints the candidates of --model auto.
void PrintModelChoice(const CalibrationResult& result) {
  if (result.model_candidates.empty()) return;
  std::vector<std::string> medians;
  for (const ModelCandidate& candidate : result.model_candidates)
    medians.push_back(
        fmt::format("{} {:.3g} px", candidate.model, candidate.median_px));
  fmt::print("  model chosen by cross-validation: {}\n",
             fmt::join(medians, ", "));
}

void PrintImageCircle(const CameraModel& camera) {
  const auto& circle = camera.image_circle();
  if (!circle) return;
  fmt::print(
      "  image circle: radius {:.1f} px, centre {:.1f}, {:.1f} (--image-circle "
      "none: calibrate the whole image)\n",
      circle->radii_px.x(), circle->center.x(), circle->center.y());
}

void PrintLineDelay(const CalibrationResult& result) {
  if (result.line_delay)
    fmt::print("  line delay: {}\n",
               FormatLineDelay(*result.line_delay,
                               result.camera.camera->image_size().height));
}

// Prints the deviation of each estimated board from the nominal geometry and
// from a plane; boards without deviation are omitted here. The report shows all
// of them.
void PrintBoards(const Pattern& pattern) {
  constexpr double kMinReportedM = 5e-7;
  constexpr int kMaxLines = 3;
  int num_reported = 0;
  for (const Board& board : pattern.boards) {
    if (board.IsPointSet()) continue;  // may be three-dimensional
    const BoardFlatness shape = MeasureFlatness(board);
    if (std::max(shape.rms_height_m, shape.rms_shift_m) < kMinReportedM)
      continue;
    if (++num_reported > kMaxLines) continue;
    fmt::print(
        "  board {}: out-of-plane deformation {:.3f} mm RMS, {:.3f} mm max; "
        "in-plane deviation {:.3f} mm RMS\n",
        board.id, 1e3 * shape.rms_height_m, 1e3 * shape.max_height_m,
        1e3 * shape.rms_shift_m);
  }
  if (num_reported > kMaxLines)
    fmt::print("  {} more boards are deformed; see the report\n",
               num_reported - kMaxLines);
}

// Prints the limiting error source and the recommended action in one line, as
// in the report.
void PrintLimit(const CalibrationResult& result) {
  if (!result.budget) return;
  const BudgetAssessment assessment = AssessBudget(*result.budget);
  if (assessment.IsDetermined())
    fmt::print("  limited by {}: {}; remedy: {}\n", assessment.limit,
               assessment.sentence, assessment.advice);
}

void PrintSingleCamera(const CalibrationResult& result) {
  fmt::print("{}: ", result.camera.camera->Name());
  PrintSize(result);
  if (result.refinement_rms_px)
    fmt::print(
        "  features refined with the initial calibration: displacement {:.2g} "
        "px RMS\n",
        *result.refinement_rms_px);
  PrintUnusedImages(result);
  PrintErrors(result);
  if (result.camera.held_out && result.cross_validated)
    fmt::print("            by cross-validation\n");
  if (result.bias_kl && result.noise_bias_kl)
    fmt::print(
        "  bias of residual directions (KL divergence): {:.3f}, {:.3f} for "
        "white noise\n",
        *result.bias_kl, *result.noise_bias_kl);
  if (result.camera.uncertainty)
    PrintUncertainty(*result.camera.uncertainty, *result.camera.camera);
#define RAYGRID_METRIC(name, title, unit, meaning) \
  if (result.name)                                 \
    fmt::print("  {}: {}\n", title, FormatMetric(*result.name, unit));
#include "evaluation/metrics.inc"
  PrintModelChoice(result);
  if (result.camera.stack) {
    PrintKnownOverRanges(result.camera);
    PrintOperatingPointModel(result.camera.stack->cameras);
  }
  PrintImageCircle(*result.camera.camera);
  PrintLineDelay(result);
  if (result.fleet_distance)
    fmt::print("  distance from the fleet: {}\n",
               result.fleet_distance->Text());
  PrintLimit(result);
  if (result.noncentrality)
    fmt::print(
        "  distance of observation lines from their common point: {:.3f} mm "
        "RMS, {:.3f} mm max\n",
        1000 * result.noncentrality->rms_m, 1000 * result.noncentrality->max_m);
}

std::string EstimateText(double value, const std::optional<double>& deviation,
                         double scale, const char* unit) {
  return (deviation ? FormatWithStdDev(value * scale, *deviation * scale)
                    : FormatThreeDigits(value * scale)) +
         " " + unit;
}

void PrintRig(const RigResult& result) {
  for (const CalibrationResult& camera : result.cameras) {
    fmt::print("{}: {}, ", camera.camera.name, camera.camera.camera->Name());
    PrintSize(camera);
    PrintUnusedImages(camera);
    PrintErrors(camera);
    PrintLineDelay(camera);
    PrintLimit(camera);
  }
  fmt::print("rig\n");
  PrintMetrics("training", ComputeTrainingMetrics(result));
  if (const auto held_out = ComputeHeldOutMetrics(result))
    PrintMetrics("held out", *held_out);
  for (const Baseline& baseline : result.baselines)
    fmt::print("  {} to {}: baseline {}, rotation {}, {} common views\n",
               result.cameras[baseline.first].camera.name,
               result.cameras[baseline.second].camera.name,
               EstimateText(baseline.distance_m, baseline.distance_stddev_m,
                            1000, "mm"),
               EstimateText(baseline.angle_rad, baseline.rotation_stddev_rad,
                            180 / M_PI, "degrees"),
               baseline.num_shared_views);
}

}  // namespace

void PrintSummary(const RigResult& result, const std::string& folder) {
  if (result.IsRig())
    PrintRig(result);
  else
    PrintSingleCamera(result.cameras.front());
  PrintBoards(result.cameras.front().pattern);
  for (const std::string& description :
       DescribeRigidTargets(result.rigid_targets, result.board_pairs))
    fmt::print("  {}\n", description);
  if (!result.rigid_targets.empty())
    fmt::print("    (use --independent-boards to estimate a pose per board)\n");
  fmt::print("  verdict: {}\n", result.assessment.word);
  for (const std::string& reason : result.assessment.reasons)
    fmt::print("    {}\n", Printable(reason));
  fmt::print("  results in {}\n", Printable(folder));
}

}  // namespace raygrid
