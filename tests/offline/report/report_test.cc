#include <functional>
#include <nlohmann/json.hpp>

#include "dataset/error.h"
#include "dataset/files.h"
#include "report/html.h"
#include "report/html_report.h"
#include "report/plots.h"
#include "report/residual_file.h"
#include "report/result_folder.h"
#include "report/result_json.h"
#include "report/rig_report.h"
#include "support.h"

namespace raygrid {
namespace {

// Names that would break out of HTML, if they could.
const char kNastyName[] = "<script>a&\"b\".png";

CalibrationResult ExampleResult() {
  CalibrationResult result;
  result.camera.camera = std::make_shared<OpenCvModel>(ExampleLens());
  result.camera.name = kNastyName;
  TestRandom random(1);
  for (int i = 0; i < 60; ++i)
    result.training.push_back({i % 2 ? kNastyName : "b.png", 0, i, 0,
                               random.PixelIn({0, 0, 639, 479}),
                               0.1 * random.NormalVector<2>()});
  result.held_out = result.training;
  result.camera.training = ComputeErrorMetrics(result.training);
  result.camera.held_out = ComputeErrorMetrics(result.held_out);
  const Feature feature = {0, 0, 0, {1, 1}};
  result.features.images = {{"b.png", {feature, feature}},
                            {kNastyName, {feature}}};
  result.rejected_images = {{kNastyName, "only <3 features"}};
  result.near_duplicates = {{"b.png", {kNastyName, "c.png"}}};
  result.rejected_features = {{kNastyName, 0, 3, 4, {10, 20}, {3, 4}}};
  result.knot_spacing_candidates = {{80, 0.02, 0.1}, {40, 0.01, 0.09}};
  result.knot_spacing_px = 40;
  result.num_parameters = 12;
  result.converged = true;
  result.bias_kl = 0.25;
  result.noise_bias_kl = 0.2;
  result.parametric_models = {{"central-radial",
                               20,
                               {0.2, 0.3, 1, 60},
                               ErrorMetrics{0.3, 0.4, 1, 60},
                               ErrorMetrics{0.21, 0.31, 1, 30},
                               1.5,
                               {}}};
  result.held_out_deformed = ErrorMetrics{0.123, 0.234, 1, 30};
  result.bends = BoardDeformation{{{"a.png", 0, 0.0001}, {"b.png", 0, 0.0002}},
                                  0.00016,
                                  1,
                                  std::vector<double>(300, 0.0002)};
  result.pattern = ChessboardPattern(60, 5, 0.01);
  result.poses = {{"b.png", 0, {Eigen::Quaterniond::Identity(), {0, 0, 1}}}};
  result.assessment = {"warn", {"only 2 images; take 10 or more"}};
  return result;
}

// A single camera's.
RigResult Alone(const CalibrationResult& camera) {
  RigResult result;
  result.cameras = {camera};
  result.camera_from_rig = {{}};
  result.pattern = camera.pattern;
  result.converged = camera.converged;
  result.assessment = camera.assessment;
  result.seconds["start"] = 0.5;
  return result;
}

std::string ExampleReport() {
  BeforeAfter example;
  example.before.size = example.after.size = {4, 3};
  example.before.pixels = example.after.pixels = std::vector<uint8_t>(12, 99);
  PackingMetrics packing;
  packing.blob_bytes = 12345;
  packing.unproject_error_px = 1e-4;
  packing.remap_error_px = 0.04;
  packing.view = {{640, 480}, {500.5, 501}, {319.5, 239.5}};
  return FormatHtmlReport(ExampleResult(), packing, example, {}, "a blob");
}

bool Has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// The page without the library, which names its own home.
std::string WithoutLibrary(const std::string& html) {
  const size_t start = html.find("<script>");
  return html.substr(0, start) + html.substr(html.find("</script>", start));
}

TEST(HtmlReport, RefersToNothingOutside) {
  const std::string html = WithoutLibrary(ExampleReport());
  for (const char* reference :
       {"http", "//cdn", "@import", "<link", "<script src", "url("})
    EXPECT_FALSE(Has(html, reference)) << reference;
  EXPECT_TRUE(Has(html, "src=\"data:image/png;base64,"));
}

TEST(HtmlReport, RunsTheRuntimeOnlyWhereThereIsABlob) {
  const std::string html = ExampleReport();
  EXPECT_TRUE(Has(html, "data-blob=\"" + Base64("a blob") + "\""));
  EXPECT_TRUE(Has(html, "<script type=\"module\">const {WASM} = "));
  for (const char* line : {"\nimport ", "\nexport "})
    EXPECT_FALSE(Has(html, line)) << line;
  const std::string without =
      FormatHtmlReport(ExampleResult(), PackingMetrics(), std::nullopt);
  for (const char* part : {"<script type=\"module\">", "id=\"trial\""})
    EXPECT_FALSE(Has(without, part)) << part;
}

TEST(HtmlReport, EscapesNames) {
  const std::string html = ExampleReport();
  EXPECT_FALSE(Has(html, kNastyName));
  EXPECT_TRUE(Has(html, "&lt;script&gt;a&amp;&quot;b&quot;.png"));
  EXPECT_TRUE(Has(html, "only &lt;3 features"));
}

TEST(HtmlReport, GivesTheVerdictBeforeTheNumbers) {
  const std::string html = ExampleReport();
  const size_t assessment = html.find("Verdict: warn");
  ASSERT_NE(assessment, std::string::npos);
  EXPECT_LT(assessment, html.find("only 2 images"));
  EXPECT_LT(html.find("only 2 images"), html.find("Reprojection error"));
  EXPECT_TRUE(Has(html, "12345 bytes"));
  EXPECT_TRUE(Has(html, "40.0 (chosen)"));
}

// Decodes base64 of a report's first picture.
std::string FirstPicture(const std::string& html) {
  const std::string digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (size_t i = html.find("base64,") + 7; html[i] != '"'; ++i) {
    if (html[i] == '=') continue;
    bits = bits << 6 | static_cast<unsigned>(digits.find(html[i]));
    if ((count += 6) < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 255);
  }
  return bytes;
}

TEST(HtmlReport, PicturesAreWholePngs) {
  const CalibrationResult result = ExampleResult();
  EXPECT_EQ(FirstPicture(ExampleReport()),
            EncodePng(DrawCoveragePlot(result.training, {640, 480},
                                       result.camera.camera->area())));
}

TEST(HtmlReport, GivesOtherModelsAndTheBiasOfNoise) {
  const std::string html = ExampleReport();
  EXPECT_TRUE(Has(html,
                  "<td>central-radial</td><td>20</td><td>0.200</td>"
                  "<td>0.300</td><td>0.400</td><td>0.210</td>"
                  "<td>1.500</td>"));
  EXPECT_TRUE(
      Has(html, "white noise at the same positions gives <b>0.200</b>"));
}

TEST(HtmlReport, ExplainsItsWordsInALineEach) {
  const std::string html = ExampleReport();
  for (const char* word :
       {"valid region", "extrapolated", "bias", "correlation"})
    EXPECT_TRUE(Has(html, std::string("<li><b>") + word + "</b>: ")) << word;
}

TEST(HtmlReport, ShowsHowTheBoardBends) {
  const std::string html = ExampleReport();
  EXPECT_TRUE(Has(html, "b.png, board 0: 0.200 mm"));
  EXPECT_TRUE(Has(html, "0.160 mm RMS"));
  EXPECT_TRUE(Has(html, "held out, with per-view deformation"));
  CalibrationResult rigid = ExampleResult();
  rigid.bends.reset();
  EXPECT_FALSE(Has(FormatHtmlReport(rigid, std::nullopt, std::nullopt, {}, ""),
                   "Per-view target deformation"));
}

TEST(HtmlReport, WorksWithoutHeldOutImagesAndExample) {
  CalibrationResult result = ExampleResult();
  result.held_out.clear();
  result.camera.held_out.reset();
  result.knot_spacing_candidates.clear();
  const std::string html =
      WithoutLibrary(FormatHtmlReport(result, PackingMetrics(), std::nullopt));
  EXPECT_FALSE(Has(html, "held out ("));
  EXPECT_FALSE(Has(html, ">nan"));
  EXPECT_TRUE(Has(html, "</html>"));
}

// ---- Result folder ---------------------------------------------------------

// A result that comes back from its files: names that CSV can hold.
CalibrationResult PlainResult() {
  CalibrationResult result = ExampleResult();
  result.camera.name = "front";
  for (auto* set :
       {&result.training, &result.held_out, &result.rejected_features})
    for (FeatureResidual& residual : *set)
      if (residual.image == kNastyName) residual.image = "a.png";
  result.features.images = {{"a.png", {{0, 0, 0, {1, 1}}}},
                            {"b.png", {{0, 1, 0, {2, 1}}}}};
  return result;
}

void WriteResultTo(const std::string& folder, const CalibrationResult& result) {
  OutputFiles files;
  CameraExtras extras;
  extras.packing = PackingMetrics{12345, 1e-4, 0.04};
  AddResultFiles(Alone(result), {0, 0, {extras}}, folder, &files);
  files.Commit();
}

std::string ReportOf(const std::string& folder) {
  OutputFiles files;
  AddReports(folder, &files);
  files.Commit();
  return ReadFile(folder + "/report.html");
}

TEST(ResultFolder, HoldsAllThatTheReportSays) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  CalibrationResult result = PlainResult();
  result.camera.uncertainty = CameraUncertainty{{2, 2, {0.1, 0.2, 0.3, 0.4}},
                                                ValidityMask::Over({640, 480}),
                                                0.05,
                                                {},
                                                {}};
  result.jackknife_scale = 1.83;
  result.fleet_distance = FleetDistance{1.7, 0.3};
  WriteResultTo(out, result);
  const std::string html = ReportOf(out);
  for (const char* part :
       {"1.83 times that of white noise", "Verdict: warn", "only 2 images",
        "12345 bytes", "40.0 (chosen)", "central-radial", "white noise",
        "(3, 4): residual 5.00 px", "front",
        "1.7 px RMS from the population mean"})
    EXPECT_TRUE(Has(html, part)) << part;
  EXPECT_EQ(ReportOf(out), html);
}

// Noise, which JPEG makes least of.
Image NoiseImage(const ImageSize& size, unsigned seed) {
  TestRandom random(seed);
  Image image;
  image.size = size;
  for (int k = 0; k < size.width * size.height; ++k)
    image.pixels.push_back(static_cast<uint8_t>(random.Index(256)));
  return image;
}

TEST(Thumbnails, AreSmallHoweverManyThereAre) {
  const TemporaryFolder folder;
  WriteFile(folder / "noise.png", EncodePng(NoiseImage({320, 240}, 1)));
  for (const int count : {1, 30, 400}) {
    Dataset dataset;
    dataset.image_size = {320, 240};
    for (int i = 0; i < count; ++i)
      dataset.images.push_back({std::to_string(i) + ".png", {}});
    std::vector<std::string> paths(count, folder / "noise.png");
    paths.back() = folder / "gone.png";
    const Thumbnails thumbnails = MakeThumbnails(dataset, paths, 2);
    EXPECT_EQ(thumbnails.size(), count - 1u);
    size_t bytes = 0;
    for (const auto& [name, jpeg] : thumbnails) bytes += jpeg.size();
    EXPECT_LE(bytes, 3000000u);
    EXPECT_EQ(MakeThumbnails(dataset, paths, 1), thumbnails);
  }
}

TEST(ReportOfAFolder, NamesImagesOfTheSameView) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  OutputFiles files;
  CalibrationResult result = PlainResult();
  result.near_duplicates = {{"b.png", {"c.png", "<d>.png"}}};
  AddResultFiles(Alone(result), {0, 0, {CameraExtras()}}, out, &files);
  files.Commit();
  EXPECT_TRUE(Has(ReportOf(out),
                  "<li>b.png represents 2 more: c.png, &lt;d&gt;.png</li>"));
}

TEST(Thumbnails, AreInTheReport) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  OutputFiles files;
  CameraExtras extras;
  extras.thumbnails = {{"b.png", "a JPEG file"}};
  AddResultFiles(Alone(PlainResult()), {0, 0, {extras}}, out, &files);
  files.Commit();
  const std::string html = ReportOf(out);
  EXPECT_TRUE(Has(
      html, "\"thumbnails\":{\"b.png\":\"" + Base64("a JPEG file") + "\"}"));
  std::filesystem::remove(out + "/thumbnails.json");
  EXPECT_FALSE(Has(ReportOf(out), "\"thumbnails\":"));
}

TEST(ResultFolder, ResidualsAreReadBack) {
  const TemporaryFolder folder;
  const CalibrationResult result = PlainResult();
  WriteFile(folder / "residuals.csv", FormatResiduals(Alone(result)));
  const ResidualSets sets = ReadResiduals(folder / "residuals.csv").at("");
  ASSERT_EQ(sets.training.size(), result.training.size());
  EXPECT_EQ(sets.rejected.size(), 1u);
  for (size_t i = 0; i < result.training.size(); ++i) {
    EXPECT_EQ(sets.training[i].image, result.training[i].image);
    EXPECT_LT((sets.training[i].error_px - result.training[i].error_px).norm(),
              2e-5);
  }
}

TEST(ResultFolder, MissingFilesAndOtherVersionsAreNamed) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  for (const std::string name : {"result.json", "residuals.csv", "camera.yaml",
                                 "poses.csv", "pattern.yaml", "features.csv"}) {
    WriteResultTo(out, PlainResult());
    std::filesystem::remove(out + "/" + name);
    ExpectError(ExitCode::kInvalidInput, {name, "missing", "calibrate"},
                [&] { ReportOf(out); });
  }
  for (const char* text :
       {"{}", "[]", "", "{\"schema_version\": 99}", "{\"schema_version\": 3}",
        "{\"schema_version\": 3, \"cameras\": [], "
        "\"verdict\": \"pass\", \"reasons\": []}"}) {
    WriteResultTo(out, PlainResult());
    WriteFile(out + "/result.json", text);
    ExpectError(ExitCode::kInvalidInput,
                {"result.json", "rerun the calibration"},
                [&] { ReportOf(out); });
  }
}

TEST(HtmlReport, ScriptMakesNoMarkupOfData) {
  const std::string html = WithoutLibrary(ExampleReport());
  for (const char* way : {"innerHTML", "outerHTML", "insertAdjacentHTML",
                          "document.write", "eval(", "Function("})
    EXPECT_FALSE(Has(html, way)) << way;
}

// A text that a browser would run, in an element's text or in an attribute.
const char kAttack[] = "\"'></script><svg/onload=alert(1)>";

// Each text of a JSON document in turn, and each key, is the attack.
void ForEachAttack(const nlohmann::ordered_json& json,
                   const std::function<void(const std::string&)>& use) {
  const nlohmann::ordered_json flat = json.flatten();
  for (const auto& [path, value] : flat.items()) {
    if (!value.is_string()) continue;
    auto attacked = flat;
    attacked[path] = kAttack;
    use(attacked.unflatten().dump());
  }
}

// A page without the attack, or none.
void ExpectHarmless(const std::string& folder, const std::string& what) {
  std::filesystem::remove(folder + "/report.html");
  try {
    ReportOf(folder);
  } catch (const InputError&) {
    return;
  }
  std::string pages = WithoutLibrary(ReadFile(folder + "/report.html"));
  for (const char* camera : {"/left/report.html", "/right/report.html"})
    if (std::filesystem::exists(folder + camera))
      pages += WithoutLibrary(ReadFile(folder + camera));
  EXPECT_FALSE(Has(pages, "<svg")) << what;
  EXPECT_FALSE(Has(pages, "\"'></script")) << what;
}

TEST(ResultFolder, NoTextInItReachesThePageAsMarkup) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  CalibrationResult result = PlainResult();
  WriteResultTo(out, result);
  ForEachAttack(nlohmann::ordered_json::parse(ReadFile(out + "/result.json")),
                [&](const std::string& attacked) {
                  WriteFile(out + "/result.json", attacked);
                  ExpectHarmless(out, attacked);
                });
  result.camera.name = kAttack;
  for (auto* set : {&result.training, &result.held_out})
    for (FeatureResidual& residual : *set) residual.image = kAttack;
  result.features.images[0].image = kAttack;
  result.poses[0].image = kAttack;
  OutputFiles files;
  CameraExtras extras;
  extras.thumbnails = {{kAttack, "a JPEG file"}};
  AddResultFiles(Alone(result), {0, 0, {extras}}, out, &files);
  files.Commit();
  ExpectHarmless(out, "names");
  EXPECT_TRUE(std::filesystem::exists(out + "/report.html"));
  WriteFile(out + "/thumbnails.json",
            nlohmann::json(
                {{"raygrid_thumbnails", 1}, {"images", {{kAttack, kAttack}}}})
                .dump());
  ExpectHarmless(out, "thumbnails");
}

TEST(ResultJson, HoldsTheFigures) {
  const auto json = nlohmann::json::parse(
      FormatResultJson(Alone(ExampleResult()), 42, 1000000));
  EXPECT_EQ(json["status"], "converged");
  EXPECT_EQ(json["model"], "opencv");
  EXPECT_EQ(json["image_size"], (std::vector<int>{640, 480}));
  EXPECT_EQ(json["images"]["used"], 2);
  EXPECT_EQ(json["features"]["used"], 3);
  EXPECT_EQ(json["features"]["rejected"], 1);
  EXPECT_EQ(json["images"]["rejected"][0]["image"], kNastyName);
  EXPECT_EQ(json["images"]["near_duplicates"][0]["image"], "b.png");
  EXPECT_EQ(json["images"]["near_duplicates"][0]["duplicates"][1], "c.png");
  EXPECT_EQ(json["training"]["count"], 60);
  EXPECT_EQ(json["held_out"]["method"], "held-out images");
  EXPECT_EQ(json["held_out_with_deformation"]["median_px"], 0.123);
  EXPECT_EQ(json["parametric_models"][0]["held_out_with_deformation"]["count"],
            30);
  EXPECT_EQ(json["target_deformation"]["rms_m"], 0.00016);
  EXPECT_EQ(json["target_deformation"]["views"][1]["image"], "b.png");
  EXPECT_EQ(json["knot_spacing_candidates"].size(), 2u);
  EXPECT_EQ(json["bias_kl"], 0.25);
  EXPECT_EQ(json["verdict"], "warn");
  EXPECT_EQ(json["seed"], 42);
}

void ExpectNoNull(const nlohmann::json& json) {
  EXPECT_FALSE(json.is_null());
  EXPECT_TRUE(!json.is_number() || std::isfinite(json.get<double>()));
  if (json.is_structured())
    for (const auto& item : json) ExpectNoNull(item);
}

TEST(ResultJson, HasNoNumberThatIsNotFinite) {
  // JSON has no NaN; the library would write null.
  ExpectNoNull(
      nlohmann::json::parse(FormatResultJson(Alone(ExampleResult()), 1, 2)));
  CalibrationResult bare = ExampleResult();
  bare.training.clear();
  bare.held_out.clear();
  bare.camera.training = ComputeErrorMetrics({});
  bare.camera.held_out.reset();
  bare.bias_kl.reset();
  bare.noise_bias_kl.reset();
  bare.parametric_models.clear();
  bare.knot_spacing_candidates.clear();
  const std::string text = FormatResultJson(Alone(bare), 1, 2);
  ExpectNoNull(nlohmann::json::parse(text));
  EXPECT_FALSE(Has(text, "bias"));
}

RigResult ExampleRig() {
  RigResult rig;
  rig.cameras = {ExampleResult(), ExampleResult()};
  rig.cameras[0].camera.name = "left";
  rig.cameras[1].camera.name = "right";
  rig.cameras[1].assessment = {"fail", {"blurred"}};
  rig.camera_from_rig = {{}, {RotationFromVector({0, 0.5, 0}), {-0.3, 0.4, 0}}};
  rig.baselines = ComputeBaselines(rig.camera_from_rig);
  rig.baselines[0].num_shared_views = 9;
  rig.baselines[0].distance_stddev_m = 0.00025;
  rig.held_out = {rig.cameras[0].held_out, rig.cameras[1].held_out};
  rig.converged = true;
  rig.assessment = AssessRig(rig);
  return rig;
}

TEST(RigResult, BaselinesAreDistancesAndAngles) {
  const RigResult rig = ExampleRig();
  ASSERT_EQ(rig.baselines.size(), 1u);
  EXPECT_NEAR(rig.baselines[0].distance_m, 0.5, 1e-12);
  EXPECT_NEAR(rig.baselines[0].angle_rad, 0.5, 1e-12);
}

TEST(RigResult, VerdictIsTheWorstAndNamesCameras) {
  RigResult rig = ExampleRig();
  EXPECT_EQ(rig.assessment.word, "fail");
  EXPECT_EQ(rig.assessment.reasons,
            (std::vector<std::string>{"left: only 2 images; take 10 or more",
                                      "right: blurred"}));
  for (CalibrationResult& camera : rig.cameras)
    camera.assessment = {"pass", {}};
  EXPECT_EQ(AssessRig(rig).word, "pass");
  rig.baselines[0].num_shared_views = 4;
  EXPECT_EQ(AssessRig(rig).word, "warn");
  EXPECT_TRUE(Has(AssessRig(rig).reasons.at(0), "left"));
  rig.baselines[0].num_shared_views = 9;
  for (FeatureResidual& residual : rig.held_out[0]) residual.error_px *= 4;
  EXPECT_EQ(AssessRig(rig).word, "warn");
  EXPECT_TRUE(Has(AssessRig(rig).reasons.at(0), "synchronized"));
}

TEST(ResultJson, HoldsEachCameraOfARig) {
  const std::string text = FormatResultJson(ExampleRig(), 42, 1000000);
  const auto json = nlohmann::json::parse(text);
  ExpectNoNull(json);
  EXPECT_EQ(json["status"], "converged");
  EXPECT_EQ(json["parameters"], 24);
  EXPECT_EQ(json["training"]["count"], 120);
  EXPECT_EQ(json["held_out"]["count"], 120);
  EXPECT_EQ(json["cameras"].size(), 2u);
  EXPECT_EQ(json["cameras"][1]["name"], "right");
  EXPECT_EQ(json["cameras"][1]["training"]["count"], 60);
  EXPECT_EQ(json["cameras"][1]["held_out_with_rig_poses"]["count"], 60);
  EXPECT_EQ(json["cameras"][1]["verdict"], "fail");
  EXPECT_EQ(json["images"]["rejected"][1]["camera"], "right");
  EXPECT_NEAR(json["baselines"][0]["distance_m"].get<double>(), 0.5, 1e-12);
  EXPECT_EQ(json["baselines"][0]["distance_sd_m"], 0.00025);
  EXPECT_FALSE(json["baselines"][0].contains("rotation_sd_rad"));
  EXPECT_EQ(json["verdict"], "fail");
}

TEST(RigReport, ListsTheCamerasAndHowTheyStand) {
  const std::string html = FormatRigReport(ExampleRig());
  for (const char* part :
       {"Verdict: fail", "href=\"left/report.html\"", "right, training",
        "500.00 &plusmn; 0.25", "28.6", "</html>"})
    EXPECT_TRUE(Has(html, part)) << part;
  for (const char* reference : {"http", "<link", "<script src", "url("})
    EXPECT_FALSE(Has(WithoutLibrary(html), reference)) << reference;
}

// A board that both cameras see at one instant has one bend, and one bar.
TEST(RigReport, DrawsTheBendsOfAllCamerasOnce) {
  RigResult rig = ExampleRig();
  rig.pattern = rig.cameras[0].pattern;
  rig.cameras[1].bends->views[0] = {"c.png", 0, 0.0004};
  rig.cameras[1].bends->most_deformed = 0;
  rig.cameras[1].bends->heights_m.assign(300, 0.0004);
  const std::string html = FormatRigReport(rig);
  // Bends are 0.1, 0.2 and 0.4 mm.
  for (const char* part :
       {"Per-view target deformation", "0.265 mm RMS", "0.400 mm max",
        "height: 25.0%\" title=\"a.png", "height: 50.0%\" title=\"b.png",
        "height: 100.0%\" title=\"c.png", "Board 0 in c.png", "400 &micro;m"})
    EXPECT_TRUE(Has(html, part)) << part;
  const size_t first = html.find("title=\"b.png");
  EXPECT_EQ(html.find("title=\"b.png", first + 1), std::string::npos);
  for (CalibrationResult& camera : rig.cameras) camera.bends.reset();
  EXPECT_FALSE(Has(FormatRigReport(rig), "Per-view target deformation"));
}

TEST(RigReport, HasOtherModelsOfEachCamera) {
  RigResult rig = ExampleRig();
  rig.cameras[0].parametric_models.clear();
  const std::string html = FormatRigReport(rig);
  for (const char* part :
       {"Other models", "right, <b>opencv</b>", "right, central-radial"})
    EXPECT_TRUE(Has(html, part)) << part;
  EXPECT_FALSE(Has(html, "left, central-radial"));
  rig.cameras[1].parametric_models.clear();
  EXPECT_FALSE(Has(FormatRigReport(rig), "Other models"));
}

TEST(RigReport, NoTextReachesItAsMarkup) {
  RigResult rig = ExampleRig();
  rig.assessment = {kAttack, {kAttack}};
  for (CalibrationResult& camera : rig.cameras) {
    camera.assessment = rig.assessment;
    camera.parametric_models[0].model = kAttack;
    camera.camera.name = kAttack;
    camera.poses[0].image = kAttack;
  }
  const std::string html = WithoutLibrary(FormatRigReport(rig));
  EXPECT_FALSE(Has(html, "<svg"));
  EXPECT_FALSE(Has(html, "\"'></script"));
}

TEST(ResultFolder, FollowsNoLink) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  WriteResultTo(out, PlainResult());
  WriteFile(folder / "mine", "mine");
  std::filesystem::create_symlink("../mine", out + "/report.html");
  EXPECT_TRUE(Has(ReportOf(out), "</html>"));
  EXPECT_EQ(ReadFile(folder / "mine"), "mine");
}

}  // namespace
}  // namespace raygrid
