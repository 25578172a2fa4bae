#include "child_program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <sstream>

#include "dataset/error.h"

namespace raygrid {
namespace {

[[noreturn]] void FailToStart(int error) {
  throw Error(ExitCode::kOutputFailed,
              fmt::format("cannot start a process ({}); close other programs, "
                          "or try again later",
                          std::strerror(error)));
}

std::vector<char*> MakeArgv(std::string* name,
                            const std::vector<std::string>& arguments) {
  std::vector<char*> texts = {name->data()};
  for (const std::string& argument : arguments)
    texts.push_back(const_cast<char*>(argument.c_str()));
  texts.push_back(nullptr);
  return texts;
}

// Runs in the child process, in its own process group: the parent handles the
// terminal's signals. Executes the running binary, even if its file has been
// replaced by another version.
[[noreturn]] void ExecChildProgram(const std::vector<std::string>& arguments,
                                   pid_t parent, int errors) {
  std::string name = "raygrid";
  const std::vector<char*> texts = MakeArgv(&name, arguments);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  setpgid(0, 0);
  const int null = open("/dev/null", O_RDWR);
  dup2(null, STDIN_FILENO);
  dup2(null, STDOUT_FILENO);
  dup2(errors, STDERR_FILENO);
  execv("/proc/self/exe", texts.data());
  std::fprintf(stderr, "raygrid: cannot start the program (%s)\n",
               std::strerror(errno));
  _exit(static_cast<int>(ExitCode::kUsage));
}

constexpr int kNotFound = 127;  // as in shells

// Runs in the child process.
[[noreturn]] void ExecProgram(std::string name,
                              const std::vector<std::string>& arguments,
                              int output) {
  const std::vector<char*> texts = MakeArgv(&name, arguments);
  dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  execvp(name.c_str(), texts.data());
  _exit(kNotFound);
}

// Returns the output written to a pipe; if longer than 64 kB, its end.
std::string ReadPipe(int pipe) {
  constexpr size_t kMaxKeptBytes = 1 << 16;
  std::string text;
  char buffer[4096];
  for (;;) {
    const ssize_t size = read(pipe, buffer, sizeof(buffer));
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return text;
    text.append(buffer, static_cast<size_t>(size));
    if (text.size() > 2 * kMaxKeptBytes)
      text.erase(0, text.size() - kMaxKeptBytes);
  }
}

std::string LastLine(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  text.erase(0, text.rfind('\n') + 1);
  const std::string name = "raygrid: ";
  return text.compare(0, name.size(), name) == 0 ? text.substr(name.size())
                                                 : text;
}

// Forks, lets the child call become() with the write end of a pipe, and waits
// until it exits. Returns its status and stores its output.
template <typename Become>
int RunToEnd(const Become& become, std::string* text) {
  int pipe[2];
  if (pipe2(pipe, O_CLOEXEC) != 0) FailToStart(errno);
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) become(pipe[1]);
  const int error = errno;
  close(pipe[1]);
  if (child < 0) {
    close(pipe[0]);
    FailToStart(error);
  }
  *text = ReadPipe(pipe[0]);
  close(pipe[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

ChildEnd RunChild(const std::vector<std::string>& arguments) {
  const pid_t parent = getpid();
  std::string text;
  const int status = RunToEnd(
      [&](int errors) { ExecChildProgram(arguments, parent, errors); }, &text);
  ChildEnd end;
  end.last_error = LastLine(text);
  if (WIFSIGNALED(status))
    end.signal = WTERMSIG(status);
  else
    end.exit_code = WEXITSTATUS(status);
  return end;
}

ProgramEnd RunProgram(const std::string& name,
                      const std::vector<std::string>& arguments) {
  std::string text;
  const int status = RunToEnd(
      [&](int output) { ExecProgram(name, arguments, output); }, &text);
  ProgramEnd end;
  constexpr int kSignal = 128;
  end.exit_code =
      WIFSIGNALED(status) ? kSignal + WTERMSIG(status) : WEXITSTATUS(status);
  end.is_found = end.exit_code != kNotFound;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) end.lines.push_back(line);
  return end;
}

}  // namespace raygrid
