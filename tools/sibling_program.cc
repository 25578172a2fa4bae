#include "sibling_program.h"

#include <unistd.h>

#include <cstdio>
#include <filesystem>

namespace raygrid {

int ExecSiblingProgram(const std::string& program,
                       const std::vector<std::string>& arguments) {
  std::vector<char*> texts = {const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments)
    texts.push_back(const_cast<char*>(argument.c_str()));
  texts.push_back(nullptr);
  std::fflush(nullptr);
  std::error_code error;
  const std::filesystem::path own =
      std::filesystem::read_symlink("/proc/self/exe", error);
  // In the same folder, as in a build tree; otherwise relative to bin/ or to
  // lib/raygrid/.
  if (!error)
    for (const char* folder : {".", "../lib/raygrid", "../../bin"})
      execv((own.parent_path() / folder / program).c_str(), texts.data());
  execvp(program.c_str(), texts.data());
  constexpr int kUsage = 1;
  std::fprintf(stderr,
               "raygrid: program %s not found beside this one or in PATH; "
               "install the Debian package raygrid, or build it\n",
               program.c_str());
  return kUsage;
}

}  // namespace raygrid
