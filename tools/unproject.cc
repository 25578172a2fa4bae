#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>

#include "camera_input.h"
#include "commands.h"
#include "dataset/csv.h"
#include "dataset/files.h"

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
    const bool is_lit = camera.IsLit(pixel);
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
  if (common.json) text = CsvAsJson(text, columns);
  PrintOrWrite(arguments.output, text);
}

}  // namespace

void AddUnproject(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "unproject",
      "Directions that pixels look along: x,y to x,y,dx,dy,dz, and of a camera "
      "that is not central ox,oy,oz, a point of the line in metres; empty "
      "fields outside the calibrated area. A blob is evaluated by the "
      "fixed-point "
      "runtime, a camera.yaml in double precision.",
      "raygrid unproject camera.raygrid --pixels px.csv -o rays.csv", common);
  auto arguments = std::make_shared<UnprojectArguments>();
  AddAtOption(command, common);
  command->add_option("camera", arguments->camera, "camera.yaml or a blob")
      ->required();
  command->add_option("--pixels", arguments->pixels, "CSV with x,y")
      ->required();
  command->add_option("-o,--output", arguments->output,
                      "CSV, or JSON with --json, to write (default: print)");
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
