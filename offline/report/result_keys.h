/// The keys of result.json that writer and reader share, and those of older
/// versions.
#ifndef RAYGRID_REPORT_RESULT_KEYS_H
#define RAYGRID_REPORT_RESULT_KEYS_H

#include <nlohmann/json.hpp>

namespace raygrid {

/// The value of "schema_version".
constexpr int kResultSchemaVersion = 2;

/// Values of "held_out": "method".
constexpr char kCrossValidation[] = "cross-validation";
constexpr char kHeldOutImages[] = "held-out images";

/// Gives a result of an older version the keys of this one, as far as they are
/// read again. False for versions that are not known.
bool UpgradeResult(nlohmann::ordered_json* result);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_RESULT_KEYS_H
