#include "exchange/lensfun_format.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/camera_keys.h"
#include "exchange/opencv_model_list.h"
#include "exchange/radial_model.h"
#include "exchange/xml.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

// Diagonal of 36 x 24 mm; the sensor diagonal is this divided by the crop
// factor.
constexpr double kDiagonalMm = 43.266615305567875;

// Lensfun measures distances between the centres of the outermost pixels.
Eigen::Vector2d SidesPx(const ImageSize& size) {
  return {std::max(1.0, size.width - 1.0), std::max(1.0, size.height - 1.0)};
}

ExternalModel MakeLensfunModel(const char* name, const char* model,
                               double max_supported_angle_rad) {
  ExternalModel external_model = {name, model, {"f", "cx", "cy", "k1", "k2"}};
  external_model.max_supported_angle_rad = max_supported_angle_rad;
  return external_model;
}

const std::vector<ExternalModel>& GetLensfunModels() {
  static const std::vector<ExternalModel> external_models = {
      MakeLensfunModel("rectilinear", models::kOpenCv, M_PI / 2),
      MakeLensfunModel("fisheye", models::kThinPrismFisheye, M_PI)};
  return external_models;
}

// ---- Reading ---------------------------------------------------------------

double LensfunNumber(const std::string& text, const std::string& name) {
  return FiniteNumber(YAML::Node(text), name);
}

double LensfunAttribute(const XmlElement& element, const std::string& name,
                        double missing) {
  const auto found = element.attributes.find(name);
  return found == element.attributes.end()
             ? missing
             : LensfunNumber(found->second, element.name + ": " + name);
}

std::string GetChildText(const XmlElement& element, const std::string& name) {
  const XmlElement* child = element.Child(name);
  return child ? child->text : "";
}

// Parses the ratio of the longer to the shorter side: "4:3" or a number.
double AspectRatio(const std::string& text) {
  if (text.empty()) return 1.5;
  const size_t colon = text.find(':');
  const double ratio =
      colon == std::string::npos
          ? LensfunNumber(text, "aspect-ratio")
          : LensfunNumber(text.substr(0, colon), "aspect-ratio") /
                LensfunNumber(text.substr(colon + 1), "aspect-ratio");
  if (!(ratio >= 1 && ratio < 100))
    throw InputError(fmt::format(
        "aspect-ratio: '{}' is not a ratio of the longer to the shorter side",
        Printable(text)));
  return ratio;
}

double CropFactor(const XmlElement& element) {
  const std::string text = GetChildText(element, "cropfactor");
  if (text.empty()) throw InputError("'cropfactor' is missing");
  const double crop = LensfunNumber(text, "cropfactor");
  if (!(crop > 0.01 && crop < 1000))
    throw InputError(fmt::format("cropfactor: {:g} is out of range", crop));
  return crop;
}

RadialProjection ReadProjection(const std::string& type) {
  static const std::map<std::string, RadialProjection> projections = {
      {"", RadialProjection::kRectilinear},
      {"rectilinear", RadialProjection::kRectilinear},
      {"fisheye", RadialProjection::kEquidistant},
      {"equisolid", RadialProjection::kEquisolid},
      {"stereographic", RadialProjection::kStereographic},
      {"orthographic", RadialProjection::kOrthographic},
      {"fisheye_thoby", RadialProjection::kThoby}};
  const auto found = projections.find(type);
  if (found == projections.end())
    throw InputError(fmt::format(
        "unsupported projection type '{}'; supported are rectilinear, fisheye, "
        "equisolid, stereographic, orthographic and fisheye_thoby",
        Printable(type)));
  return found->second;
}

// Distorted radius as a function of the undistorted radius r, both in units of
// half the shorter side of the calibration images: d r + c1 r^2 + c2 r^3 + c3
// r^4 + c4 r^5.
struct Polynomial {
  double d = 1;
  std::array<double, 4> c = {};
};

Polynomial ReadPolynomial(const XmlElement& distortion) {
  const auto found = distortion.attributes.find("model");
  const std::string model =
      found == distortion.attributes.end() ? "" : found->second;
  const auto value = [&](const char* name) {
    return LensfunAttribute(distortion, name, 0);
  };
  if (model.empty() || model == "none") return {};
  if (model == "poly3") return {1 - value("k1"), {0, value("k1"), 0, 0}};
  if (model == "poly5") return {1, {0, value("k1"), 0, value("k2")}};
  if (model == "ptlens") {
    const double a = value("a"), b = value("b"), c = value("c");
    return {1 - a - b - c, {c, b, a, 0}};
  }
  throw InputError(
      fmt::format("line {}: unsupported distortion model '{}'; supported are "
                  "poly3, poly5 and ptlens",
                  distortion.line, Printable(model)));
}

// Returns the paraxial focal length of the file in mm; the nominal focal length
// refers to undistorted images.
double ParaxialFocalMm(const XmlElement& calibration, double nominal_mm,
                       double d) {
  for (const XmlElement& element : calibration.children)
    if (element.name == "real-focal-length" &&
        LensfunAttribute(element, "focal", NAN) == nominal_mm)
      return LensfunAttribute(element, "real-focal", nominal_mm * d);
  return nominal_mm * d;
}

// Makes the camera model of a lens at one focal length. crop: the camera's crop
// factor.
RadialModel ReadRadialModel(const XmlElement& lens,
                            const XmlElement& calibration,
                            const XmlElement& distortion, double crop,
                            const ImageSize& size) {
  const double focal_mm = LensfunAttribute(distortion, "focal", NAN);
  if (!(focal_mm > 0))
    throw InputError(fmt::format(
        "line {}: missing focal length of the distortion", distortion.line));
  const Polynomial polynomial = ReadPolynomial(distortion);
  if (!(polynomial.d > 0))
    throw InputError(
        fmt::format("line {}: the distortion is degenerate at the image centre",
                    distortion.line));
  const Eigen::Vector2d sides_px = SidesPx(size);
  const double pixels_per_mm = sides_px.norm() * crop / kDiagonalMm;
  const double unit_mm =
      kDiagonalMm / CropFactor(lens) / 2 /
      std::hypot(1, AspectRatio(GetChildText(lens, "aspect-ratio")));
  const double paraxial_mm =
      ParaxialFocalMm(calibration, focal_mm, polynomial.d);
  RadialModel radial;
  radial.projection = ReadProjection(GetChildText(lens, "type"));
  radial.focal_px.setConstant(paraxial_mm * pixels_per_mm);
  Eigen::Vector2d off_center(0, 0);
  if (const XmlElement* center = lens.Child("center"))
    off_center = {LensfunAttribute(*center, "x", 0),
                  LensfunAttribute(*center, "y", 0)};
  radial.center_px = sides_px / 2 + off_center * sides_px.minCoeff() / 2;
  // Substitutes t = d r unit / f, the ideal radius in focal lengths.
  const double scale = paraxial_mm / polynomial.d / unit_mm;
  double power = 1 / polynomial.d;
  for (size_t k = 0; k < radial.coefficients.size(); ++k)
    radial.coefficients[k] = polynomial.c[k] * (power *= scale);
  return radial;
}

// Returns the projection and distortion model, e.g. "equisolid ptlens".
std::string MakeLensName(const XmlElement& lens, const XmlElement& distortion) {
  const std::string type = GetChildText(lens, "type");
  const auto model = distortion.attributes.find("model");
  return fmt::format(
      "{} {}", type.empty() ? "rectilinear" : type,
      model == distortion.attributes.end() ? "none" : model->second);
}

std::string FileName(const std::string& text) {
  std::string name;
  for (const char c : text)
    name += std::isalnum(static_cast<unsigned char>(c)) || c == '_' ? c : '-';
  return name;
}

// Returns the camera's crop factor if the file has exactly one camera.
std::optional<double> ReadCropFactor(const std::vector<XmlElement>& elements) {
  std::optional<double> crop;
  for (const XmlElement& element : elements) {
    if (element.name != "camera") continue;
    if (crop) return std::nullopt;
    crop = CropFactor(element);
  }
  return crop;
}

void RequireKnownElements(const XmlElement& lens,
                          std::vector<std::string>* warnings) {
  YAML::Node map(YAML::NodeType::Map);
  for (const XmlElement& child : lens.children)
    if (!map[child.name].IsDefined()) map[child.name] = child.text;
  const CameraKeys keys(map);
  keys.Skip({"maker", "model", "variant", "notes", "mount", "type", "focal",
             "aperture", "cropfactor", "aspect-ratio", "center",
             "calibration"});
  keys.Finish(GetLensfunModels()[0], warnings);
}

ExchangeContents ReadLensfun(const ReadRequest& request) {
  constexpr size_t kMost = 32;
  const XmlElement root = ParseXml(request.text);
  const std::vector<XmlElement> elements =
      root.name == "lens" ? std::vector<XmlElement>{root} : root.children;
  const std::optional<double> crop_factor = ReadCropFactor(elements);
  if (!request.size)
    throw InputError("missing image size; specify --image-size WxH");
  ExchangeContents contents;
  for (const XmlElement& lens : elements) {
    const XmlElement* calibration = lens.Child("calibration");
    if (lens.name != "lens" || !calibration) continue;
    RequireKnownElements(lens, &contents.warnings);
    for (const XmlElement& distortion : calibration->children) {
      if (distortion.name != "distortion") continue;
      if (contents.cameras.size() == kMost)
        throw InputError(
            fmt::format("more than {} distortions; copy the one of your lens "
                        "and focal length into a separate file",
                        kMost));
      const RadialModel radial = ReadRadialModel(
          lens, *calibration, distortion,
          crop_factor.value_or(CropFactor(lens)), *request.size);
      InputCamera& camera = contents.cameras.emplace_back();
      camera.name =
          fmt::format("{}-{}mm", FileName(GetChildText(lens, "model")),
                      FileName(distortion.attributes.at("focal")));
      camera.lens = MakeRadialCamera(MakeLensName(lens, distortion),
                                     *request.size, radial, &contents.warnings);
    }
  }
  if (contents.cameras.size() == 1 && !elements.empty())
    for (const XmlElement& lens : elements)
      if (lens.Child("calibration"))
        contents.cameras.front().name = GetChildText(lens, "model");
  return contents;
}

// ---- Writing ---------------------------------------------------------------

// Escapes text for XML, including the sequence that ends comments.
std::string EscapeXml(const std::string& text) {
  std::string escaped;
  for (const char c : Printable(text))
    escaped += c == '<'   ? "&lt;"
               : c == '>' ? "&gt;"
               : c == '&' ? "&amp;"
                          : std::string(1, c);
  return escaped;
}

// Writes a camera with crop factor 1 and the size of the calibration images.
std::string WriteLensfun(const WriteRequest& request) {
  const OutputCamera& camera = request.cameras.front();
  const ConvertedCamera& lens = camera.lens;
  const Eigen::Vector2d sides_px = SidesPx(lens.size);
  const double mm_per_pixel = kDiagonalMm / sides_px.norm();
  const double smaller_px = sides_px.minCoeff();
  const double focal_px = lens.Value("f");
  // Converts units of the focal length to units of half the shorter side.
  const double scale = smaller_px / 2 / focal_px;
  std::string text = "<lensdatabase version=\"1\">\n";
  if (camera.fit)
    text += fmt::format("    <!-- Fitted {}: {} -->\n",
                        lens.external_model->name, FormatModelFit(*camera.fit));
  return text +
         fmt::format(
             "    <lens>\n"
             "        <maker>raygrid</maker>\n"
             "        <model>{}</model>\n"
             "        <mount>Generic</mount>\n"
             "        <type>{}</type>\n"
             "        <cropfactor>1</cropfactor>\n"
             "        <aspect-ratio>{}</aspect-ratio>\n"
             "        <center x=\"{}\" y=\"{}\"/>\n"
             "        <calibration>\n"
             "            <distortion model=\"poly5\" focal=\"{}\" k1=\"{}\" "
             "k2=\"{}\"/>\n"
             "        </calibration>\n"
             "    </lens>\n"
             "</lensdatabase>\n",
             camera.name.empty() ? "camera" : EscapeXml(camera.name),
             lens.external_model->name,
             FormatReal(sides_px.maxCoeff() / smaller_px),
             FormatReal((lens.Value("cx") - sides_px.x() / 2) * 2 / smaller_px),
             FormatReal((lens.Value("cy") - sides_px.y() / 2) * 2 / smaller_px),
             FormatReal(focal_px * mm_per_pixel),
             FormatReal(lens.Value("k1") * scale * scale),
             FormatReal(lens.Value("k2") * std::pow(scale, 4)));
}

}  // namespace

Format MakeLensfunFormat() {
  Format format;
  format.name = "lensfun";
  format.holds =
      "Lensfun database .xml: poly3, poly5 and ptlens (ptlens and rare "
      "projections converted to central-generic); written as poly5";
  format.external_models = GetLensfunModels();
  format.ending = ".xml";
  format.discards_rig_poses = true;
  format.requires_image_size = true;
  format.recognizes = [](const std::string& text) {
    return text.find("<lensdatabase") != std::string::npos ||
           (text.find("<lens>") != std::string::npos &&
            text.find("<distortion") != std::string::npos);
  };
  format.read = ReadLensfun;
  format.write = WriteLensfun;
  return format;
}

}  // namespace raygrid
