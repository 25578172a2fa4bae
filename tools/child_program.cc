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

#include "dataset/error.h"

namespace raygrid {
namespace {

[[noreturn]] void FailToStart(int error) {
  throw Error(ExitCode::kOutput,
              fmt::format("no program can be started ({}); end others, or "
                          "run this again later",
                          std::strerror(error)));
}

// In the new process: a signal for a terminal's processes is its parent's.
// The program is the very one that runs, also if another version took its
// place.
[[noreturn]] void BecomeChild(const std::vector<std::string>& arguments,
                              pid_t parent, int errors) {
  std::string name = "raygrid";
  std::vector<char*> texts = {name.data()};
  for (const std::string& argument : arguments)
    texts.push_back(const_cast<char*>(argument.c_str()));
  texts.push_back(nullptr);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  setpgid(0, 0);
  const int null = open("/dev/null", O_RDWR);
  dup2(null, STDIN_FILENO);
  dup2(null, STDOUT_FILENO);
  dup2(errors, STDERR_FILENO);
  execv("/proc/self/exe", texts.data());
  std::fprintf(stderr, "raygrid: cannot be started (%s)\n",
               std::strerror(errno));
  _exit(static_cast<int>(ExitCode::kUsage));
}

// All that is written to a pipe, or its last 64 kB.
std::string ReadPipe(int pipe) {
  constexpr size_t kKept = 1 << 16;
  std::string text;
  char buffer[4096];
  for (;;) {
    const ssize_t size = read(pipe, buffer, sizeof(buffer));
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return text;
    text.append(buffer, static_cast<size_t>(size));
    if (text.size() > 2 * kKept) text.erase(0, text.size() - kKept);
  }
}

std::string LastLine(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  text.erase(0, text.rfind('\n') + 1);
  const std::string name = "raygrid: ";
  return text.compare(0, name.size(), name) == 0 ? text.substr(name.size())
                                                 : text;
}

}  // namespace

ChildEnd RunChild(const std::vector<std::string>& arguments) {
  int pipe[2];
  if (pipe2(pipe, O_CLOEXEC) != 0) FailToStart(errno);
  std::fflush(nullptr);
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child == 0) BecomeChild(arguments, parent, pipe[1]);
  const int error = errno;
  close(pipe[1]);
  if (child < 0) {
    close(pipe[0]);
    FailToStart(error);
  }
  ChildEnd end;
  end.last_error = LastLine(ReadPipe(pipe[0]));
  close(pipe[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status))
    end.signal = WTERMSIG(status);
  else
    end.exit_code = WEXITSTATUS(status);
  return end;
}

}  // namespace raygrid
