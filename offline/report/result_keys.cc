#include "report/result_keys.h"

#include <cmath>
#include <string>
#include <vector>

namespace raygrid {
namespace {

using Json = nlohmann::ordered_json;

// A renamed key. `object`: the key of the object that contains it, or of the
// list of such objects; empty for the result itself and for the cameras of a
// rig. Numbers are multiplied by the scale.
struct RenamedKey {
  const char* object;
  const char* old_key;
  const char* current;
  double scale = 1;
};

constexpr double kMm = 1e-3;
constexpr double kDegrees = M_PI / 180;

using RenamedKeys = std::vector<RenamedKey>;

// Keys of version 1 that version 2 replaced. They are looked up in objects that
// are already renamed to version 2.
const RenamedKeys kRenamedInVersion2 = {
    {"", "cell_px", "knot_spacing_px"},
    {"", "cell_candidates", "knot_spacing_candidates"},
    {"knot_spacing_candidates", "cell_px", "knot_spacing_px"},
    {"images", "same_views", "near_duplicates"},
    {"near_duplicates", "others", "duplicates"},
    {"images", "held_out_copies", "held_out_duplicates"},
    {"features", "used_without_error", "used_without_residual"},
    {"features", "measured_again_rms_px", "refinement_shift_rms_px"},
    {"held_out", "by", "method"},
    {"", "held_out_flexed", "held_out_deformed"},
    {"parametric_models", "held_out_flexed", "held_out_deformed"},
    {"", "board_bends", "target_deformation"},
    {"target_deformation", "rms_mm", "rms_m", kMm},
    {"target_deformation", "most_bent", "largest_view"},
    {"target_deformation", "most_bent_heights_mm", "largest_view_heights_m",
     kMm},
    {"views", "rms_mm", "rms_m", kMm},
    {"", "noise_bias_kl", "bias_kl_white_noise"},
    {"", "neighbor_correlation", "residual_autocorrelation"},
    {"uncertainty", "max_trusted_px", "valid_limit_px"},
    {"uncertainty", "trusted_part", "valid_share"},
    {"", "row_time", "line_delay"},
    {"line_delay", "row_time_us", "value_us"},
    {"line_delay", "deviation_us", "sd_us"},
    {"line_delay", "untold", "not_observable"},
    {"line_delay", "times_fit", "timestamps_consistent"},
    {"line_delay", "taken_out", "compensated"},
    {"line_delay", "left_out", "uncompensated_images"},
    {"", "line_spread", "noncentrality"},
    {"", "fold_over", "non_injective"},
    {"non_injective", "part", "share"},
    {"non_injective", "trusted_part", "valid_share"},
    {"", "fleet_distance", "population_distance"},
    {"population_distance", "units_px", "population_px"},
    {"residual_budget", "sentence", "summary"},
    {"residual_budget", "to_do", "recommendation"},
    {"residual_budget", "untold", "not_observable"},
    {"residual_budget", "noise", "noise_share"},
    {"residual_budget", "large_errors", "outlier_share"},
    {"residual_budget", "of_views", "per_view_share"},
    {"residual_budget", "rest", "unexplained_share"},
    {"residual_budget", "column_time", "column_delay"},
    {"column_delay", "alone", "share_alone"},
    {"column_delay", "alike", "indistinguishable"},
    {"causes", "untold", "not_observable"},
    {"causes", "part", "share"},
    {"causes", "alone", "share_alone"},
    {"causes", "chance_high", "chance_upper_bound"},
    {"causes", "alike", "indistinguishable"},
    {"tried", "cell_px", "knot_spacing_px"},
    {"tried", "cells_chosen", "knot_spacing_selected"},
    {"tried", "tried_finer", "finer_spacing_tested"},
    {"tried", "points_free", "target_geometry_estimated"},
    {"tried", "bends_tried", "per_view_deformation_tested"},
    {"tried", "central-generic", "central_generic_tested"},
    {"tried", "noncentral-generic", "noncentral_generic_tested"},
    {"tried", "two_cameras", "two_cameras_suspected"},
    {"packing", "remarks", "warnings"},
    {"", "board_bodies", "rigid_targets"},
    {"", "boards_told", "rigid_target_summary"},
    {"board_pairs", "fixed", "rigid"},
    {"board_pairs", "instants", "frames"},
    {"board_pairs", "deviation_mm", "translation_sd_m", kMm},
    {"board_pairs", "deviation_degrees", "rotation_sd_rad", kDegrees},
    {"board_pairs", "expected_mm", "expected_translation_sd_m", kMm},
    {"board_pairs", "expected_degrees", "expected_rotation_sd_rad", kDegrees},
};

const RenamedKeys kRenamedInVersion3 = {
    {"", "seconds", "stage_seconds"},
    {"", "held_out_deformed", "held_out_with_deformation"},
    {"parametric_models", "held_out_deformed", "held_out_with_deformation"},
    {"", "held_out_in_rig", "held_out_with_rig_poses"},
    {"uncertainty", "share_below_px", "fraction_below_px"},
    {"uncertainty", "valid_share", "valid_fraction"},
    {"extrapolated", "share", "fraction"},
    {"extrapolated", "where", "location"},
    {"over_operating_range", "valid_share", "valid_fraction"},
    {"residual_budget", "noise_share", "noise_fraction"},
    {"residual_budget", "outlier_share", "outlier_fraction"},
    {"residual_budget", "per_view_share", "per_view_fraction"},
    {"residual_budget", "unexplained_share", "unexplained_fraction"},
    {"causes", "share", "fraction"},
    {"causes", "share_alone", "fraction_alone"},
    {"column_delay", "share_alone", "fraction_alone"},
    {"non_injective", "share", "fraction"},
    {"non_injective", "valid_share", "valid_fraction"},
    {"population_distance", "population_px", "population_rms_px"},
    {"rectified_pair", "disparities", "num_disparities"},
};

void Scale(double scale, Json* value) {
  if (value->is_number())
    *value = scale * value->get<double>();
  else if (value->is_array())
    for (Json& element : *value) Scale(scale, &element);
}

// Recursively renames the keys of an object that is stored under the given key.
void Rename(const RenamedKeys& renamed_keys, const std::string& object,
            Json* json) {
  if (json->is_array()) {
    for (Json& element : *json) Rename(renamed_keys, object, &element);
    return;
  }
  if (!json->is_object()) return;
  for (const RenamedKey& key : renamed_keys) {
    if (object != key.object || !json->contains(key.old_key) ||
        json->contains(key.current))
      continue;
    (*json)[key.current] = (*json)[key.old_key];
    json->erase(key.old_key);
    if (key.scale != 1) Scale(key.scale, &(*json)[key.current]);
  }
  for (auto& [key, value] : json->items())
    Rename(renamed_keys, key == "cameras" ? "" : key, &value);
}

}  // namespace

bool UpgradeResult(nlohmann::ordered_json* result) {
  const auto has = [&](const char* key, int value) {
    return result->contains(key) && result->at(key) == value;
  };
  if (has("schema_version", kResultSchemaVersion)) return true;
  if (has("raygrid_result", 1)) {
    Rename(kRenamedInVersion2, "", result);
    result->erase("raygrid_result");
  } else if (!has("schema_version", 2)) {
    return false;
  }
  Rename(kRenamedInVersion3, "", result);
  (*result)["schema_version"] = kResultSchemaVersion;
  return true;
}

}  // namespace raygrid
