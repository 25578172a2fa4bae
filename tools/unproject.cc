#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>

#include "camera_input.h"
#include "commands.h"
#include "dataset/csv.h"
#include "dataset/files.h"
#include "help_formatter.h"

namespace raygrid {
namespace {

struct UnprojectArguments {
  std::string camera, pixels, output;
};

std::string FormatVector(const Eigen::Vector3d& vector) {
  return fmt::format("{:.12f},{:.12f},{:.12f}", vector.x(), vector.y(),
                     vector.z());
}

void Run(const UnprojectArguments& arguments, const CommonOptions& common) {
  RequireNoInputReplaced({arguments.camera, arguments.pixels},
                         {arguments.output});
  const CameraInput input = ReadCamera(arguments.camera, common.at);
  const std::string csv = ReadFile(arguments.pixels);
  CsvReader table(arguments.pixels, csv, {"x", "y"});
  table.LimitRows(MaxRows(common.json));
  const CameraModel& camera = *input.file.camera;
  const bool has_origins = !camera.IsCentral();
  std::vector<std::string> columns = {"x", "y", "dx", "dy", "dz"};
  if (has_origins) columns.insert(columns.end(), {"ox", "oy", "oz"});
  std::string text = fmt::format("{}\n", fmt::join(columns, ","));
  while (table.Next()) {
    const Eigen::Vector2d pixel(table.Number("x"), table.Number("y"));
    text += fmt::format("{},{},", table.Text("x"), table.Text("y"));
    const bool is_lit = camera.IsInImageCircle(pixel);
    const auto ray = !is_lit      ? std::nullopt
                     : input.blob ? input.blob->Unproject(pixel)
                                  : camera.Unproject(pixel);
    text += ray ? FormatVector(*ray) : ",,";
    if (has_origins) {
      const auto line = !is_lit      ? std::nullopt
                        : input.blob ? input.blob->Line(pixel)
                                     : camera.Line(pixel);
      text += "," + (line ? FormatVector(line->origin) : ",,");
    }
    text += "\n";
  }
  if (common.json) text = ConvertCsvToJson(text, columns);
  PrintOrWrite(arguments.output, text);
}

}  // namespace

void AddUnproject(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "unproject", "Unproject pixels to observation rays.",
      "raygrid unproject camera.raygrid --pixels px.csv -o rays.csv", common);
  auto arguments = std::make_shared<UnprojectArguments>();
  AddCameraArgument(command, &arguments->camera);
  command->add_option("--pixels", arguments->pixels, "CSV with columns x,y")
      ->option_text("FILE")
      ->required();
  BeginGroup(command, help_group::kModel);
  AddAtOption(command, common);
  BeginGroup(command, help_group::kOutput);
  command
      ->add_option(
          "-o,--output", arguments->output,
          "CSV x,y,dx,dy,dz (if non-central also ox,oy,oz in m); empty outside "
          "the calibrated area (default: standard output)")
      ->option_text("FILE");
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
