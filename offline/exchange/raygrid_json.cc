#include "exchange/raygrid_json.h"

#include "dataset/text_encoding.h"

namespace raygrid {

Json MakeRaygridJson(const WrittenLens& camera) {
  Json own = Json::object();
  if (!camera.name.empty()) own["name"] = Printable(camera.name);
  if (!camera.serial.empty()) own["serial"] = Printable(camera.serial);
  if (camera.fit) own["fit"] = FormatLensFit(*camera.fit);
  return own;
}

void ParseRaygridJson(const YAML::Node& own, ReadLens* camera) {
  if (!own.IsDefined() || !own.IsMap()) return;
  const auto text_of = [&](const char* key) {
    return own[key] && own[key].IsScalar() ? own[key].as<std::string>() : "";
  };
  camera->name = text_of("name");
  camera->serial = text_of("serial");
}

}  // namespace raygrid
