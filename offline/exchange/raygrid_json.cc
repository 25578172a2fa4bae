#include "exchange/raygrid_json.h"

#include "dataset/text_encoding.h"

namespace raygrid {

Json MakeRaygridJson(const OutputCamera& camera) {
  Json own = Json::object();
  if (!camera.name.empty()) own["name"] = Printable(camera.name);
  if (!camera.serial.empty()) own["serial"] = Printable(camera.serial);
  if (camera.fit) own["fit"] = FormatModelFit(*camera.fit);
  return own;
}

void ParseRaygridJson(const YAML::Node& own, InputCamera* camera) {
  if (!own.IsDefined() || !own.IsMap()) return;
  const auto get_text = [&](const char* key) {
    return own[key] && own[key].IsScalar() ? own[key].as<std::string>() : "";
  };
  camera->name = get_text("name");
  camera->serial = get_text("serial");
}

}  // namespace raygrid
