/// The object that raygrid adds to other programs' JSON, which ignore it: name,
/// serial and fit error.
#ifndef RAYGRID_EXCHANGE_RAYGRID_JSON_H
#define RAYGRID_EXCHANGE_RAYGRID_JSON_H

#include <yaml-cpp/yaml.h>

#include <nlohmann/json.hpp>

#include "exchange/format.h"

namespace raygrid {

/// JSON with preserved key order.
using Json = nlohmann::ordered_json;

constexpr char kRaygridKey[] = "raygrid";

Json MakeRaygridJson(const OutputCamera& camera);

/// Sets name and serial if the object exists.
void ParseRaygridJson(const YAML::Node& own, InputCamera* camera);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_RAYGRID_JSON_H
