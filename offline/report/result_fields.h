/// The fields of result.json that are both written and read.
#ifndef RAYGRID_REPORT_RESULT_FIELDS_H
#define RAYGRID_REPORT_RESULT_FIELDS_H

#include <array>

#include "evaluation/budget_assessment.h"
#include "report/json_fields.h"
#include "report/result_json.h"
#include "report/result_keys.h"

namespace raygrid {

template <class Io>
void VisitFields(Io& io, ErrorMetrics& metrics) {
  io("median_px", metrics.median_px);
  io("rms_px", metrics.rms_px);
  io("max_px", metrics.max_px);
  io("count", metrics.count);
}

template <class Io>
void VisitFields(Io& io, ViewMetrics& view) {
  std::array<int, 2> size = {view.size.width, view.size.height};
  std::array<std::array<double, 3>, 3> K = {
      {{view.focal_px.x(), 0, view.center_px.x()},
       {0, view.focal_px.y(), view.center_px.y()},
       {0, 0, 1}}};
  io.Computed([](auto* json) { (*json)["projection"] = "pinhole"; });
  io("size", size);
  io("K", K);
  if (Io::kReads)
    view = {{size[0], size[1]}, {K[0][0], K[1][1]}, {K[0][2], K[1][2]}};
}

template <class Io>
void VisitFields(Io& io, PackingMetrics& packing) {
  io.When(packing.blob_bytes > 0, "blob_bytes", packing.blob_bytes);
  io.When(packing.blob_bytes > 0, "unproject_error_px",
          packing.unproject_error_px);
  io("remap_error_px", packing.remap_error_px);
  io("view", packing.view);
  io.NonEmpty("warnings", packing.warnings);
}

template <class Io>
void VisitFields(Io& io, StereoMetrics& stereo) {
  io("left", stereo.left);
  io("right", stereo.right);
  io.Choice("orientation", stereo.is_vertical, "vertical", "horizontal");
  io("rms_px", stereo.rms_px);
  io("max_px", stereo.max_px);
  io("count", stereo.num_features);
  io("image", stereo.frame);
  io("num_disparities", stereo.num_disparities);
}

/// Without the cameras, which are written as names.
template <class Io>
void VisitFields(Io& io, Baseline& baseline) {
  io("common_views", baseline.num_shared_views);
  io("distance_m", baseline.distance_m);
  io("distance_sd_m", baseline.distance_stddev_m);
  io("angle_rad", baseline.angle_rad);
  io("rotation_sd_rad", baseline.rotation_stddev_rad);
  std::optional<std::array<std::array<double, 6>, 6>> rows;
  if (baseline.covariance) {
    rows.emplace();
    for (int i = 0; i < 6; ++i)
      for (int k = 0; k < 6; ++k) (*rows)[i][k] = (*baseline.covariance)(i, k);
  }
  io("covariance", rows);
  if (!Io::kReads || !rows) return;
  baseline.covariance.emplace();
  for (int i = 0; i < 6; ++i)
    for (int k = 0; k < 6; ++k) (*baseline.covariance)(i, k) = (*rows)[i][k];
}

template <class Io>
void VisitFields(Io& io, RejectedImage& image) {
  io("image", image.image);
  io("reason", image.reason);
}

template <class Io>
void VisitFields(Io& io, NearDuplicates& group) {
  io("image", group.image);
  io("duplicates", group.others);
}

template <class Io>
void VisitFields(Io& io, BoardDeformation::View& view) {
  io("image", view.image);
  io("board", view.board);
  io("rms_m", view.rms_m);
}

template <class Io>
void VisitFields(Io& io, BoardDeformation& deformation) {
  io("rms_m", deformation.rms_m);
  io("views", deformation.views);
  io("largest_view", deformation.most_deformed);
  io("largest_view_heights_m", deformation.heights_m);
}

template <class Io>
void VisitFields(Io& io, KnotSpacingCandidate& candidate) {
  io("knot_spacing_px", candidate.knot_spacing_px);
  io("held_out_loss", candidate.loss);
  io("median_px", candidate.median_px);
}

template <class Io>
void VisitFields(Io& io, ModelCandidate& candidate) {
  io("model", candidate.model);
  io("cross_validated_loss", candidate.loss);
  io("median_px", candidate.median_px);
  io("gain_standard_errors", candidate.gain);
}

template <class Io>
void VisitFields(Io& io, ModelMetrics& metrics) {
  io("model", metrics.model);
  io("parameters", metrics.num_parameters);
  io("training", metrics.training);
  io("held_out", metrics.held_out);
  io("held_out_with_deformation", metrics.held_out_deformed);
  io("bias_kl", metrics.bias_kl);
}

template <class Io>
void VisitFields(Io& io, ExtrapolatedRegion& region) {
  io("fraction", region.share);
  io.When(region.share > 0, "p95_px", region.p95_px);
  io.When(region.share > 0, "location", region.image_regions);
}

template <class Io>
void VisitFields(Io& io, FoldOver& fold_over) {
  io("fraction", fold_over.part);
  io("valid_fraction", fold_over.valid_fraction);
}

template <class Io>
void VisitFields(Io& io, FleetDistance& distance) {
  io("rms_px", distance.rms_px);
  io("population_rms_px", distance.units_px);
  io.Computed([&](auto* json) {
    if (distance.IsOutlier()) (*json)["warning"] = distance.Warning();
  });
}

template <class Io>
void VisitFields(Io& io, Noncentrality& spread) {
  io("rms_m", spread.rms_m);
  io("max_m", spread.max_m);
}

template <class Io>
void VisitFields(Io& io, LineDelayEstimate& line_delay) {
  const bool is_determined = line_delay.IsDetermined();
  double value_us = line_delay.value.seconds * 1e6;
  double stddev_us = line_delay.value.stddev_s * 1e6;
  io.When(is_determined, "value_us", value_us);
  io.When(is_determined, "sd_us", stddev_us);
  if (Io::kReads) line_delay.value = {value_us * 1e-6, stddev_us * 1e-6};
  io.When(!is_determined, "not_observable", line_delay.unobservable_reason);
  io.When(!is_determined && !line_delay.are_timestamps_consistent,
          "timestamps_consistent", line_delay.are_timestamps_consistent);
  io("images", line_delay.num_images);
  io("compensated", line_delay.is_compensated);
  io.When(line_delay.num_left_out > 0, "uncompensated_images",
          line_delay.num_left_out);
}

template <class Io>
void VisitFields(Io& io, BudgetSummary& facts) {
  io("model", facts.model);
  io("knot_spacing_px", facts.knot_spacing_px);
  io("knot_spacing_selected", facts.knot_spacing_selected);
  io("finer_spacing_tested", facts.has_tried_finer_grid);
  io("target_geometry_estimated", facts.has_estimated_points);
  io("per_view_deformation_tested", facts.has_tried_deformation);
  io("central_generic_tested", facts.has_tried_generic_model);
  io("noncentral_generic_tested", facts.has_tried_noncentral_model);
  io("two_cameras_suspected", facts.mixed_cameras);
  io.NonEmpty("better_model", facts.better_model);
}

template <class Io>
void VisitFields(Io& io, CauseShare& share) {
  io.When(!share.is_observable, "not_observable", share.unobservable_reason);
  if constexpr (Io::kReads) share.is_observable = !io.Has("not_observable");
  if (!share.is_observable) return;
  io("fraction", share.sequential_share);
  io("fraction_alone", share.alone);
  io("chance_mean", share.random_mean);
  io("chance_upper_bound", share.random_limit);
  io("indistinguishable", share.is_indistinguishable);
}

/// Fractions of the sum of squared residuals, and the limiting cause, which is
/// derived from them.
template <class Io>
void VisitFields(Io& io, ResidualBudget& budget) {
  io.Computed([&](auto* json) {
    const BudgetAssessment assessment = AssessBudget(budget);
    *json = {{"limited_by", assessment.limit},
             {"summary", assessment.sentence},
             {"recommendation", assessment.advice}};
  });
  io("features", budget.num_features);
  io("views", budget.num_views);
  io("tried", budget.facts);
  io.NonEmpty("not_observable", budget.unobservable_reason);
  if (!budget.unobservable_reason.empty()) return;
  io("rms_px", budget.rms_px);
  io("noise_px", budget.noise_px);
  io("noise_fraction", budget.noise);
  io("outlier_fraction", budget.large);
  io.Array("causes", budget.causes.size(), [&](auto& cause, size_t k) {
    cause.Computed([&](auto* json) {
      (*json)["cause"] = ToString(static_cast<ErrorCause>(k));
    });
    VisitFields(cause, budget.causes[k]);
  });
  io.Object("column_delay", budget.PerViewShare() > 0, [&](auto& column_delay) {
    column_delay("fraction_alone", budget.column_delay);
    column_delay("indistinguishable", budget.is_column_delay_indistinguishable);
  });
  io.Computed([&](auto* json) {
    (*json)["per_view_fraction"] = budget.PerViewShare();
  });
  io("unexplained_fraction", budget.rest);
}

// Keys that are computed from other data of the result, and not read.
void AddGeometry(const CameraModel& camera, nlohmann::ordered_json* json);
void AddUncertaintySummary(const CameraFile& file,
                           nlohmann::ordered_json* json);
void AddUncertaintyOverRange(const CameraFile& file,
                             nlohmann::ordered_json* json);
void AddCircleAndRanges(const CameraFile& file, nlohmann::ordered_json* json);

template <class Io>
void VisitImages(Io& io, CalibrationResult& result) {
  io.Computed(
      [&](auto* json) { (*json)["used"] = result.features.images.size(); });
  io.NonEmpty("near_duplicates", result.near_duplicates);
  io.NonEmpty("held_out_duplicates", result.held_out_duplicates);
  io("rejected", result.rejected_images);
}

template <class Io>
void VisitFeatures(Io& io, CalibrationResult& result) {
  io.Computed([&](auto* json) {
    *json = {{"used", result.features.num_features()},
             {"rejected", result.rejected_features.size()}};
    if (const size_t count = CountMissingErrors(result))
      (*json)["used_without_residual"] = count;
  });
  io("refinement_shift_rms_px", result.refinement_rms_px);
}

template <class Io>
void VisitErrors(Io& io, CalibrationResult& result) {
  if (Io::kReads) result.camera.training.emplace();
  io("training", *result.camera.training);
  auto& held_out = result.camera.held_out;
  io.Object("held_out", held_out.has_value(), [&](auto& fields) {
    if (Io::kReads) held_out.emplace();
    VisitFields(fields, *held_out);
    fields.Choice("method", result.cross_validated, kCrossValidation,
                  kHeldOutImages);
  });
  io("held_out_with_deformation", result.held_out_deformed);
}

template <class Io>
void VisitUncertainty(Io& io, CalibrationResult& result) {
  io.Computed([&](auto* json) { AddUncertaintySummary(result.camera, json); });
  io("extrapolated", result.extrapolated);
  io.When(true, "jackknife_scale", result.jackknife_scale);
  io.Computed(
      [&](auto* json) { AddUncertaintyOverRange(result.camera, json); });
}

/// Visits the keys of one camera, alone or in a rig.
template <class Io>
void VisitCamera(Io& io, CalibrationResult& result) {
  io.Computed([&](auto* json) { AddGeometry(*result.camera.camera, json); });
  io.When(result.has_known_intrinsics, "known_intrinsics",
          result.has_known_intrinsics);
  io("parameters", result.num_parameters);
  io.When(result.knot_spacing_px > 0, "knot_spacing_px",
          result.knot_spacing_px);
  io.Object("images", true, [&](auto& images) { VisitImages(images, result); });
  io.Object("features", true,
            [&](auto& features) { VisitFeatures(features, result); });
  VisitErrors(io, result);
  io("target_deformation", result.bends);
  io.NonEmpty("knot_spacing_candidates", result.knot_spacing_candidates);
  io("bias_kl", result.bias_kl);
  io("bias_kl_white_noise", result.noise_bias_kl);
  io.NonEmpty("model_candidates", result.model_candidates);
  io.NonEmpty("parametric_models", result.parametric_models);
#define RAYGRID_METRIC(name, ...) io(#name, result.name);
#include "evaluation/metrics.inc"
  io.Object("uncertainty", result.camera.uncertainty.has_value(),
            [&](auto& fields) { VisitUncertainty(fields, result); });
  io.Computed([&](auto* json) { AddCircleAndRanges(result.camera, json); });
  io("residual_budget", result.budget);
  io.When(true, "non_injective", result.fold_over);
  io("population_distance", result.fleet_distance);
  io("line_delay", result.line_delay);
  io("noncentrality", result.noncentrality);
}

}  // namespace raygrid

#endif  // RAYGRID_REPORT_RESULT_FIELDS_H
