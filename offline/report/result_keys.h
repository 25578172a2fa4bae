/// Keys of result.json shared by writer and reader, and of older versions.
#ifndef RAYGRID_REPORT_RESULT_KEYS_H
#define RAYGRID_REPORT_RESULT_KEYS_H

#include <nlohmann/json.hpp>

namespace raygrid {

/// The value of "schema_version".
constexpr int kResultSchemaVersion = 3;

/// Values of "held_out": "method".
constexpr char kCrossValidation[] = "cross-validation";
constexpr char kHeldOutImages[] = "held-out images";

/// Renames the keys of an older version to the current ones. Returns false for
/// unknown versions.
bool UpgradeResult(nlohmann::ordered_json* result);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_RESULT_KEYS_H
