#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "camera_input.h"
#include "commands.h"
#include "dataset/csv.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "help_formatter.h"

namespace raygrid {
namespace {

struct ProjectArguments {
  std::string camera, points, output;
};

// Scales a point, without changing its image, such that its squared norm does
// not overflow. For a central camera, the distance is irrelevant; for others, a
// point is scaled only at distances above 2^100 m.
Eigen::Vector3d ScaleToAvoidOverflow(const Eigen::Vector3d& point,
                                     bool is_central) {
  constexpr int kFarAway = 100;
  int exponent = 0;
  std::frexp(point.cwiseAbs().maxCoeff(), &exponent);
  const int shift = is_central ? -exponent : std::min(0, kFarAway - exponent);
  return point.unaryExpr([shift](double x) { return std::ldexp(x, shift); });
}

// Projects with the fixed-point runtime if the input is a blob.
std::optional<Eigen::Vector2d> Project(const CameraInput& input,
                                       const Eigen::Vector3d& point) {
  const CameraModel& camera = *input.file.camera;
  const Eigen::Vector3d scaled_point =
      ScaleToAvoidOverflow(point, camera.IsCentral());
  const auto pixel = input.blob ? input.blob->Project(scaled_point)
                                : camera.Project(scaled_point);
  return pixel && camera.IsInImageCircle(*pixel) ? pixel : std::nullopt;
}

void RequireProjection(const std::string& path, const CameraInput& input) {
  if (!input.blob || input.blob->CanProject()) return;
  throw Error(ExitCode::kInvalidBlob,
              fmt::format("{}: has no inverse grid and cannot project; pack it "
                          "again, or use its camera.yaml",
                          path));
}

void Run(const ProjectArguments& arguments, const CommonOptions& common) {
  RequireNoInputReplaced({arguments.camera, arguments.points},
                         {arguments.output});
  const CameraInput input = ReadCamera(arguments.camera, common.at);
  RequireProjection(arguments.camera, input);
  const std::string csv = ReadFile(arguments.points);
  CsvReader table(arguments.points, csv, {"x", "y", "z"});
  table.LimitRows(MaxRows(common.json));
  std::string text = "x,y,z,u,v,valid\n";
  while (table.Next()) {
    const Eigen::Vector3d point(table.Number("x"), table.Number("y"),
                                table.Number("z"));
    const auto pixel = Project(input, point);
    text += fmt::format("{},{},{},", table.Text("x"), table.Text("y"),
                        table.Text("z"));
    text += pixel ? fmt::format("{:.8f},{:.8f},1\n", pixel->x(), pixel->y())
                  : std::string(",,0\n");
  }
  if (common.json)
    text = ConvertCsvToJson(text, {"x", "y", "z", "u", "v", "valid"});
  PrintOrWrite(arguments.output, text);
}

}  // namespace

void AddProject(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "project", "Project 3D points to pixels.",
      "raygrid project camera.yaml --points xyz.csv -o px.csv", common);
  auto arguments = std::make_shared<ProjectArguments>();
  AddCameraArgument(command, &arguments->camera);
  command
      ->add_option("--points", arguments->points,
                   "CSV with columns x,y,z in the camera frame")
      ->option_text("FILE")
      ->required();
  BeginGroup(command, help_group::kModel);
  AddAtOption(command, common);
  BeginGroup(command, help_group::kOutput);
  command
      ->add_option("-o,--output", arguments->output,
                   "CSV x,y,z,u,v,valid; invalid outside the calibrated area "
                   "(default: standard output)")
      ->option_text("FILE");
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
