#include "batch_slurm.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "child_program.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "json_output.h"

namespace raygrid {
namespace {

// Slurm's default limit of tasks per job array.
constexpr size_t kMaxTasks = 1000;

// Quotes an argument for the shell.
std::string QuoteForShell(const std::string& text) {
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
  return word + "'";
}

// Escapes a path so that sbatch expands no pattern in it.
std::string SlurmPath(const std::string& path) {
  std::string text;
  for (const char c : path) text += c == '%' ? "%%" : std::string(1, c);
  return text;
}

std::string AbsolutePath(const std::string& path) {
  return std::filesystem::absolute(path).lexically_normal().string();
}

// Returns the arguments that both jobs pass to the program.
std::string BatchCommand(const std::string& plan, const std::string& output,
                         const CommonOptions& common, int threads) {
  const std::string program =
      std::filesystem::read_symlink("/proc/self/exe").string();
  return fmt::format("exec {} batch {} -o {} --threads {} --seed {} --quiet",
                     QuoteForShell(program), QuoteForShell(AbsolutePath(plan)),
                     QuoteForShell(AbsolutePath(output)), threads, common.seed);
}

// Returns the shell arithmetic for the units of task t of n: as evenly
// distributed as possible.
std::string FormatTaskUnits(size_t num_units, size_t num_tasks) {
  const auto format_begin = [&](const char* task) {
    return fmt::format("({}) * {} / {}", task, num_units, num_tasks);
  };
  return fmt::format("--unit $(({}))-$(({} - 1))",
                     format_begin("SLURM_ARRAY_TASK_ID"),
                     format_begin("SLURM_ARRAY_TASK_ID + 1"));
}

// Returns the ID of the job that sbatch submitted. sbatch prints one line: the
// ID, or the ID and the cluster's name.
std::string SubmittedJob(const std::vector<std::string>& options) {
  std::vector<std::string> words = {"--parsable"};
  words.insert(words.end(), options.begin(), options.end());
  const ProgramEnd end = RunProgram("sbatch", words);
  if (!end.is_found)
    throw Error(ExitCode::kUsage,
                "--slurm: sbatch not found in PATH; install and configure "
                "slurm-client, or distribute the units with GNU parallel "
                "(offline/fleet/README.md)");
  if (end.exit_code != 0)
    throw Error(
        ExitCode::kOutputFailed,
        fmt::format("--slurm: sbatch refused: {}",
                    end.lines.empty() ? "no message" : end.lines.back()));
  for (const std::string& line : end.lines) {
    const std::string job = line.substr(0, line.find(';'));
    if (!job.empty() &&
        job.find_first_not_of("0123456789") == std::string::npos)
      return job;
  }
  throw Error(ExitCode::kOutputFailed,
              "--slurm: sbatch did not print a job ID");
}

}  // namespace

void SubmitToSlurm(const std::string& plan, const std::string& output,
                   size_t num_units, const CommonOptions& common) {
  const size_t num_tasks = std::min(num_units, kMaxTasks);
  const int threads = std::max(common.threads, 1);
  const std::string logs = AbsolutePath(output) + "/.slurm";
  RequireWritableFolder(logs);
  const std::string command = BatchCommand(plan, output, common, threads);
  const std::string log = "--output=" + SlurmPath(logs);
  const std::string array_job = SubmittedJob(
      {"--job-name=raygrid-batch", fmt::format("--array=0-{}", num_tasks - 1),
       fmt::format("--cpus-per-task={}", threads), "--requeue",
       "--open-mode=append", log + "/%a.log",
       "--wrap=" + command + " " + FormatTaskUnits(num_units, num_tasks)});
  const std::string gather_job = SubmittedJob(
      {"--job-name=raygrid-gather", "--dependency=afterany:" + array_job,
       "--requeue", "--open-mode=append", log + "/gather.log",
       "--wrap=" + command + " --gather"});
  if (common.json)
    PrintCommandJson({{"array_job_id", array_job},
                      {"tasks", num_tasks},
                      {"gather_job_id", gather_job}});
  else if (!common.quiet)
    fmt::print(
        "Job {}: {} units in {} tasks. Job {} then writes fleet.csv and "
        "fleet.html. Logs: {}\n",
        array_job, num_units, num_tasks, gather_job, logs);
}

}  // namespace raygrid
