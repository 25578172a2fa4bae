#include "exchange/metashape_format.h"

#include <fmt/format.h>

#include <cmath>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"
#include "exchange/opencv_forms.h"
#include "exchange/xml.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kRoot[] = "calibration";

// p1 and p2 have each other's name in OpenCV and raygrid. Metashape bends a
// frame camera's x and y over z, and a fisheye's where these are as long as the
// angle off the axis. A frame has f in x and y, and b1 more in x.
const std::vector<LensForm>& MetashapeForms() {
  static const std::vector<LensForm> forms = [] {
    std::vector<LensForm> made = {
        FormOf("frame", "opencv", {"k1", "k2", "k3", "p2", "p1"}),
        FormOf("fisheye", "thin-prism-fisheye",
               {"k1", "k2", "k3", "k4", "p2", "p1"})};
    for (LensForm& form : made) {
      form.origin = PixelOrigin::kImageMiddle;
      form.reach_rad = M_PI / 2;
    }
    return made;
  }();
  return forms;
}

// Metashape's names of a form's coefficients, in its order.
std::vector<std::string> KeysOf(const LensForm& form) {
  return form.Has("k4")
             ? std::vector<std::string>{"k1", "k2", "k3", "k4", "p1", "p2"}
             : std::vector<std::string>{"k1", "k2", "k3", "p1", "p2"};
}

// ---- Reading ---------------------------------------------------------------

// A number of the file; those of Metashape that are 0 may be missing.
double NumberOf(const XmlElement& root, const std::string& name,
                std::optional<double> missing = 0) {
  const XmlElement* element = root.Child(name);
  if (!element && missing) return *missing;
  if (!element) throw InputError(fmt::format("'{}' is missing", name));
  return FiniteNumber(YAML::Node(element->text), name);
}

const LensForm& FormOfProjection(const XmlElement& root) {
  const XmlElement* projection = root.Child("projection");
  const std::string name = projection ? projection->text : "frame";
  const std::vector<LensForm>& forms = MetashapeForms();
  if (name == "frame") return forms[0];
  if (name == "fisheye" || name == "equidistant_fisheye") return forms[1];
  throw InputError(
      fmt::format("projection '{}' is none that raygrid has; those are frame, "
                  "fisheye and equidistant_fisheye",
                  Printable(name)));
}

// A form has no place for some numbers that bend the lens.
void RequireNothingElse(const XmlElement& root, const LensForm& form) {
  std::vector<std::string> others = {"b2", "p3", "p4"};
  if (!form.Has("k4")) others.push_back("k4");
  for (const std::string& name : others)
    if (NumberOf(root, name) != 0)
      throw InputError(fmt::format(
          "{} of a {} is not 0, and no lens of raygrid has it; optimize the "
          "cameras in Metashape without it",
          name, form.name));
  for (const char* name : {"fx", "fy", "skew"})
    if (root.Child(name))
      throw InputError(fmt::format(
          "'{}' is of PhotoScan before 1.2; export it from a newer one", name));
  if (root.Child("corrections"))
    throw InputError(
        "'corrections' bend the lens, and no lens of raygrid has them; "
        "optimize the cameras in Metashape without them");
}

LensInForm ReadMetashapeLens(const XmlElement& root,
                             const ReadRequest& request) {
  LensInForm lens;
  lens.form = &FormOfProjection(root);
  RequireNothingElse(root, *lens.form);
  const auto side_of = [&](const char* name) {
    const double side = NumberOf(root, name, std::nullopt);
    return SidePx(YAML::Node(side), name);
  };
  lens.size = request.size ? *request.size
                           : ImageSize{side_of("width"), side_of("height")};
  const double f = NumberOf(root, "f", std::nullopt);
  lens.values = {f + NumberOf(root, "b1"), f, NumberOf(root, "cx"),
                 NumberOf(root, "cy")};
  for (const std::string& key : KeysOf(*lens.form))
    lens.values.push_back(NumberOf(root, key));
  return lens;
}

ExchangeContents ReadMetashape(const ReadRequest& request) {
  const XmlElement root = ParseXml(request.text);
  if (root.name != kRoot)
    throw InputError(fmt::format("the root element is '{}', not '{}'",
                                 Printable(root.name), kRoot));
  for (const XmlElement& child : root.children)
    if (root.Child(child.name) != &child)
      throw InputError(fmt::format("line {}: '{}' stands twice; keep one",
                                   child.line, Printable(child.name)));
  if (!request.form.empty())
    throw InputError(
        "a calibration of Metashape says its model itself; leave "
        "--model out");
  ExchangeContents contents;
  ReadLens camera;
  camera.lens = ReadMetashapeLens(root, request);
  contents.cameras.push_back(std::move(camera));
  return contents;
}

bool IsMetashape(const std::string& text) {
  return text.find("<calibration>") != std::string::npos;
}

// ---- Writing ---------------------------------------------------------------

std::string WriteMetashape(const WriteRequest& request) {
  const WrittenLens& camera = request.cameras.front();
  const LensInForm& lens = camera.lens;
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  if (camera.fit)
    text += fmt::format("<!-- The nearest {}: {} -->\n", lens.form->name,
                        LensFitText(*camera.fit));
  text += fmt::format("<{}>\n", kRoot);
  const auto add = [&](const std::string& name, const std::string& value) {
    text += fmt::format("  <{0}>{1}</{0}>\n", name, value);
  };
  const double fx = lens.Value("fx"), fy = lens.Value("fy");
  add("projection", lens.form->name);
  add("width", std::to_string(lens.size.width));
  add("height", std::to_string(lens.size.height));
  add("f", RealText(fy));
  add("cx", RealText(lens.Value("cx")));
  add("cy", RealText(lens.Value("cy")));
  add("b1", RealText(fx - fy));
  const std::vector<std::string> keys = KeysOf(*lens.form);
  const std::vector<double> coefficients = lens.ValuesFrom(4);
  for (size_t k = 0; k < keys.size(); ++k)
    add(keys[k], RealText(coefficients[k]));
  return text + fmt::format("</{}>\n", kRoot);
}

}  // namespace

Format MetashapeFormat() {
  Format format;
  format.name = "metashape";
  format.holds =
      "Agisoft Metashape's calibration .xml of a frame or fisheye camera; of a "
      "rig a file for each camera";
  format.forms = MetashapeForms();
  format.ending = ".xml";
  format.drops_rigs = true;
  format.recognizes = IsMetashape;
  format.read = ReadMetashape;
  format.write = WriteMetashape;
  return format;
}

}  // namespace raygrid
