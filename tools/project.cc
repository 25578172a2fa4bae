#include <fmt/format.h>

#include <memory>

#include "camera_input.h"
#include "commands.h"
#include "dataset/csv.h"
#include "dataset/files.h"

namespace raygrid {
namespace {

struct Arguments {
  std::string camera, points, output;
};

void Run(const Arguments& arguments, bool json) {
  const CameraInput input = ReadCamera(arguments.camera);
  const CsvTable table(arguments.points, ReadFile(arguments.points),
                       {"x", "y", "z"});
  std::string text = "x,y,z,u,v,valid\n";
  for (size_t i = 0; i < table.num_rows(); ++i) {
    const Eigen::Vector3d point(table.Number(i, "x"), table.Number(i, "y"),
                                table.Number(i, "z"));
    const auto pixel = input.file.camera->Project(point);
    text += fmt::format("{},{},{},", table.Text(i, "x"), table.Text(i, "y"),
                        table.Text(i, "z"));
    text += pixel ? fmt::format("{:.8f},{:.8f},1\n", pixel->x(), pixel->y())
                  : std::string(",,0\n");
  }
  if (json) text = CsvAsJson(text, {"x", "y", "z", "u", "v", "valid"});
  PrintOrWrite(arguments.output, text);
}

}  // namespace

void AddProject(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "project",
      "Pixels that show 3D points: x,y,z to x,y,z,u,v,valid; not valid outside "
      "the calibrated area.",
      "raygrid project camera.yaml --points xyz.csv -o px.csv", common);
  auto arguments = std::make_shared<Arguments>();
  command->add_option("camera", arguments->camera, "camera.yaml or a blob")
      ->required();
  command->add_option("--points", arguments->points, "CSV with x,y,z")
      ->required();
  command->add_option("-o,--output", arguments->output,
                      "CSV, or JSON with --json, to write (default: print)");
  command->callback([arguments, common] { Run(*arguments, common->json); });
}

}  // namespace raygrid
