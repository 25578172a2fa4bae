#include <fmt/format.h>

#include <memory>

#include "commands.h"
#include "report/result_folder.h"

namespace raygrid {
namespace {

void WriteReport(const std::string& folder, const CommonOptions& common) {
  OutputFiles files;
  AddReports(folder, &files);
  files.Commit();
  if (common.json)
    fmt::print("{{\"report\": \"report.html\"}}\n");
  else if (!common.quiet)
    fmt::print("report.html in {}\n", folder);
}

}  // namespace

void AddReport(CLI::App* app, CommonOptions* common) {
  CLI::App* command =
      AddCommand(app, "report", "Rebuild report.html from a result folder.",
                 "raygrid report result/", common);
  auto folder = std::make_shared<std::string>();
  command->add_option("folder", *folder, "output folder of calibrate")
      ->required();
  command->callback([folder, common] { WriteReport(*folder, *common); });
}

}  // namespace raygrid
