#include "report/result_keys.h"

#include "dataset/error.h"
#include "evaluation/rig_result.h"
#include "report/result_json.h"
#include "support.h"

namespace raygrid {
namespace {

using Json = nlohmann::ordered_json;

// A result as version 0.2 wrote it.
constexpr char kVersion1[] = R"({
  "raygrid_result": 1, "status": "converged", "model": "central-generic",
  "image_size": [640, 480], "parameters": 300, "cell_px": 40.0,
  "images": {"used": 3, "same_views": [{"image": "a", "others": ["b"]}],
             "held_out_copies": ["c"], "rejected": []},
  "features": {"used": 9, "rejected": 0, "measured_again_rms_px": 0.1},
  "training": {"median_px": 0.1, "rms_px": 0.2, "max_px": 1, "count": 9},
  "held_out": {"median_px": 0.1, "rms_px": 0.2, "max_px": 1, "count": 9,
               "by": "cross-validation"},
  "held_out_flexed": {"median_px": 0.3, "rms_px": 0.4, "max_px": 1, "count": 9},
  "board_bends": {"rms_mm": 0.5,
                  "views": [{"image": "a", "board": 0, "rms_mm": 0.25}],
                  "most_bent": 0, "most_bent_heights_mm": [1.0, -2.0]},
  "cell_candidates": [
    {"cell_px": 40.0, "held_out_loss": 0.01, "median_px": 0.1}],
  "bias_kl": 0.2, "noise_bias_kl": 0.1, "neighbor_correlation": 0.4,
  "parametric_models": [
    {"model": "opencv", "parameters": 8,
     "training": {"median_px": 0.1, "rms_px": 0.2, "max_px": 1, "count": 9},
     "held_out_flexed":
       {"median_px": 0.7, "rms_px": 0.8, "max_px": 1, "count": 9}}],
  "uncertainty": {"median_px": 0.02, "max_trusted_px": 0.025,
                  "trusted_part": 0.5, "jackknife_scale": 1.5},
  "residual_budget": {
    "limited_by": "noise", "sentence": "noise", "to_do": "more", "features": 9,
    "views": 3,
    "tried": {"model": "central-generic", "cell_px": 40.0, "cells_chosen": true,
              "tried_finer": true, "points_free": false, "bends_tried": true,
              "central-generic": false, "noncentral-generic": true,
              "two_cameras": false},
    "rms_px": 0.2, "noise_px": [0.1, 0.1], "noise": 0.9, "large_errors": 0.01,
    "causes": [
      {"cause": "image place", "untold": "too few"},
      {"cause": "board place", "part": 0.02, "alone": 0.03,
       "chance_mean": 0.001, "chance_high": 0.002, "alike": true},
      {"cause": "bends", "untold": "x"}, {"cause": "in-plane", "untold": "x"},
      {"cause": "image affine", "untold": "x"},
      {"cause": "row time", "untold": "x"}],
    "column_time": {"alone": 0.04, "alike": true}, "of_views": 0.0,
    "rest": 0.05},
  "fold_over": {"part": 0.1, "trusted_part": 0.0},
  "fleet_distance": {"rms_px": 1.5, "units_px": 0.5},
  "row_time": {"row_time_us": 20.0, "deviation_us": 0.5, "images": 3,
               "taken_out": true, "left_out": 1},
  "line_spread": {"rms_m": 0.001, "max_m": 0.002},
  "packing": {"blob_bytes": 9, "unproject_error_px": 0.001,
              "remarks": ["no table"]},
  "boards_told": ["boards 0 and 1 are rigid"],
  "seconds": {}, "peak_memory_bytes": 0, "seed": 0, "verdict": "pass",
  "reasons": []})";

TEST(ResultKeys, ResultsOfVersion1AreRead) {
  const ResultMetrics metrics = ParseResultJson("result.json", kVersion1);
  const CalibrationResult& camera = metrics.result.cameras.front();
  EXPECT_EQ(camera.knot_spacing_px, 40);
  EXPECT_EQ(camera.near_duplicates[0].others[0], "b");
  EXPECT_EQ(camera.held_out_duplicates[0], "c");
  EXPECT_EQ(camera.refinement_rms_px, 0.1);
  EXPECT_TRUE(camera.cross_validated);
  EXPECT_EQ(camera.held_out_deformed->median_px, 0.3);
  EXPECT_DOUBLE_EQ(camera.bends->rms_m, 0.0005);
  EXPECT_DOUBLE_EQ(camera.bends->views[0].rms_m, 0.00025);
  EXPECT_DOUBLE_EQ(camera.bends->heights_m[1], -0.002);
  EXPECT_EQ(camera.knot_spacing_candidates[0].knot_spacing_px, 40);
  EXPECT_EQ(camera.noise_bias_kl, 0.1);
  EXPECT_EQ(camera.residual_autocorrelation, 0.4);
  EXPECT_EQ(camera.parametric_models[0].held_out_deformed->median_px, 0.7);
  EXPECT_EQ(camera.jackknife_scale, 1.5);
  EXPECT_FALSE(camera.extrapolated);
  EXPECT_EQ(camera.fleet_distance->units_px, 0.5);
  EXPECT_DOUBLE_EQ(camera.line_delay->value.stddev_s, 0.5e-6);
  EXPECT_TRUE(camera.line_delay->is_compensated);
  EXPECT_EQ(camera.line_delay->num_left_out, 1);
  EXPECT_EQ(camera.noncentrality->max_m, 0.002);
  EXPECT_EQ(metrics.packing[0]->warnings[0], "no table");
  EXPECT_EQ(metrics.rigid_target_summary.size(), 1u);
}

TEST(ResultKeys, BudgetsOfVersion1AreRead) {
  const ResultMetrics metrics = ParseResultJson("result.json", kVersion1);
  const ResidualBudget& budget = *metrics.result.cameras.front().budget;
  EXPECT_EQ(budget.noise, 0.9);
  EXPECT_EQ(budget.large, 0.01);
  EXPECT_EQ(budget.rest, 0.05);
  EXPECT_TRUE(budget.is_column_delay_indistinguishable);
  EXPECT_EQ(budget.facts.knot_spacing_px, 40);
  EXPECT_TRUE(budget.facts.has_tried_finer_grid);
  EXPECT_TRUE(budget.facts.has_tried_noncentral_model);
  EXPECT_EQ(budget.Of(ErrorCause::kImagePosition).unobservable_reason,
            "too few");
  EXPECT_EQ(budget.Of(ErrorCause::kBoardPosition).sequential_share, 0.02);
  EXPECT_EQ(budget.Of(ErrorCause::kBoardPosition).random_limit, 0.002);
}

TEST(ResultKeys, KeysOfVersion2AreRenamed) {
  Json result = {{"schema_version", 2},
                 {"seconds", {{"detection", 1.5}}},
                 {"uncertainty",
                  {{"valid_share", 0.5},
                   {"share_below_px", {{"0.05", 0.25}}},
                   {"extrapolated", {{"share", 0.1}, {"where", "corners"}}}}},
                 {"rectified_pair", {{"disparities", 64}}},
                 {"cameras",
                  {{{"held_out_in_rig", {{"count", 9}}},
                    {"residual_budget",
                     {{"noise_share", 0.9},
                      {"causes", {{{"share", 0.2}, {"share_alone", 0.3}}}}}},
                    {"population_distance", {{"population_px", 0.5}}}}}}};
  ASSERT_TRUE(UpgradeResult(&result));
  EXPECT_EQ(result["schema_version"], kResultSchemaVersion);
  EXPECT_EQ(result["stage_seconds"]["detection"], 1.5);
  const Json& uncertainty = result["uncertainty"];
  EXPECT_EQ(uncertainty["valid_fraction"], 0.5);
  EXPECT_EQ(uncertainty["fraction_below_px"]["0.05"], 0.25);
  EXPECT_EQ(uncertainty["extrapolated"]["fraction"], 0.1);
  EXPECT_EQ(uncertainty["extrapolated"]["location"], "corners");
  EXPECT_EQ(result["rectified_pair"]["num_disparities"], 64);
  const Json& camera = result["cameras"][0];
  EXPECT_EQ(camera["held_out_with_rig_poses"]["count"], 9);
  EXPECT_EQ(camera["residual_budget"]["noise_fraction"], 0.9);
  EXPECT_EQ(camera["residual_budget"]["causes"][0]["fraction"], 0.2);
  EXPECT_EQ(camera["residual_budget"]["causes"][0]["fraction_alone"], 0.3);
  EXPECT_EQ(camera["population_distance"]["population_rms_px"], 0.5);
}

TEST(ResultKeys, CamerasOfARigGetTheKeysOfToday) {
  Json rig = {{"raygrid_result", 1},
              {"cameras", {{{"name", "left"}, {"cell_px", 40}}}},
              {"board_pairs", {{{"deviation_mm", 2.0}, {"fixed", true}}}}};
  ASSERT_TRUE(UpgradeResult(&rig));
  EXPECT_EQ(rig["schema_version"], kResultSchemaVersion);
  EXPECT_EQ(rig["cameras"][0]["knot_spacing_px"], 40);
  EXPECT_DOUBLE_EQ(rig["board_pairs"][0]["translation_sd_m"], 0.002);
  EXPECT_EQ(rig["board_pairs"][0]["rigid"], true);
}

TEST(ResultKeys, OtherVersionsAreNotKnown) {
  for (Json json : {Json{{"schema_version", 99}}, Json{{"raygrid_result", "1"}},
                    Json::object()})
    EXPECT_FALSE(UpgradeResult(&json)) << json;
}

}  // namespace
}  // namespace raygrid
