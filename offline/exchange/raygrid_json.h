/// The map that raygrid adds to other programs' JSON, which they pass over:
/// name, serial and error of the fit.
#ifndef RAYGRID_EXCHANGE_RAYGRID_JSON_H
#define RAYGRID_EXCHANGE_RAYGRID_JSON_H

#include <yaml-cpp/yaml.h>

#include <nlohmann/json.hpp>

#include "exchange/format.h"

namespace raygrid {

/// JSON that keeps the order of keys.
using Json = nlohmann::ordered_json;

constexpr char kRaygridKey[] = "raygrid";

Json MakeRaygridJson(const WrittenLens& camera);

/// Sets name and serial, if such a map is there.
void ParseRaygridJson(const YAML::Node& own, ReadLens* camera);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_RAYGRID_JSON_H
