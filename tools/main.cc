#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <numeric>
#include <string>
#include <vector>

#include "commands.h"
#include "dataset/csv.h"
#include "dataset/edit_distance.h"
#include "dataset/error.h"
#include "dataset/image_header.h"
#include "dataset/memory_retention.h"
#include "dataset/text_encoding.h"
#include "help_formatter.h"
#include "renamed_options.h"

namespace raygrid {
// Replaces CLI::PositiveNumber, whose message contains the largest double in
// digits.
CLI::Validator AboveZero() {
  return CLI::Validator(
      [](const std::string& text) {
        double value = 0;
        const bool is_above = CLI::detail::lexical_cast(text, value) &&
                              value > 0 && std::isfinite(value);
        return is_above ? std::string() : text + " is not a positive number";
      },
      "POSITIVE");
}

// Splits an example that is too long for one line.
std::string ExampleLines(const std::string& example) {
  constexpr size_t kMaxWidth = 76;  // without the backslash
  if (example.size() <= kMaxWidth + 2) return "  " + example;
  const size_t space = example.rfind(" -", kMaxWidth);
  return "  " + example.substr(0, space) + " \\\n    " +
         example.substr(space + 1);
}

CLI::App* AddCommand(CLI::App* app, const std::string& name,
                     const std::string& description, const std::string& example,
                     CommonOptions* common) {
  CLI::App* command = app->add_subcommand(name, description);
  command->footer("Example:\n" + ExampleLines(example));
  command->get_help_ptr()
      ->description("print this help")
      ->group(help_group::kAdvanced);
  BeginGroup(command, help_group::kAdvanced);
  command
      ->add_option("--threads", common->threads,
                   "number of threads; 0: one per core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command->add_option("--seed", common->seed, "random seed")
      ->capture_default_str();
  command->add_flag("--quiet", common->quiet, "print errors only");
  command->add_flag("--json", common->json,
                    "print the result as JSON on standard output");
  BeginGroup(command, help_group::kInput);
  return command;
}

void AddHoldOut(CLI::App* command, const std::string& help,
                std::vector<std::string>* names) {
  command
      ->add_option_function<std::vector<std::string>>(
          "--hold-out",
          [names](const std::vector<std::string>& texts) {
            try {
              for (const std::string& text : texts)
                for (std::string& name : ParseCsvRecord("--hold-out", text))
                  names->push_back(std::move(name));
            } catch (const InputError& error) {
              throw Error(ExitCode::kUsage, error.what());
            }
          },
          help + "; comma-separated, quote names that contain commas")
      ->option_text("NAME,...");
}

void AddAtOption(CLI::App* command, CommonOptions* common) {
  command
      ->add_option_function<std::string>(
          "--at",
          [common](const std::string& text) {
            common->at = ParseRequestedOperatingPoint(text);
          },
          "operating point: focus in dioptres or temperature in °C; for both: "
          "lens_position=V,temperature=V (default: centre of the range)")
      ->option_text("VALUE");
}

void AddHugeOption(CLI::App* command) {
  command
      ->add_flag_callback(
          "--allow-huge-images", AllowHugeImages,
          fmt::format("accept images wider or higher than {} px", kMaxSidePx))
      ->group(help_group::kAdvanced);
}

namespace {

int Fail(ExitCode code, const std::string& message) {
  const std::string line = "raygrid: " + Printable(message) + "\n";
  std::fputs(line.c_str(), stderr);  // does not throw
  return static_cast<int>(code);
}

// Rejects NaN, which CLI::Range accepts, and infinity.
std::string ExplainNonFinite(const std::string& text) {
  double value = 0;
  return CLI::detail::lexical_cast(text, value) && !std::isfinite(value)
             ? text + " is not a finite number"
             : std::string();
}

// Rejects negative values, which the parser would wrap to large unsigned ones.
std::string ExplainNegative(const std::string& text) {
  return text.find('-') == std::string::npos ? std::string()
                                             : text + " is negative";
}

// Rejects empty values, which unset variables of shell scripts produce.
std::string ExplainEmpty(const std::string& text) {
  return text.empty() ? "empty value; specify a value or omit the option"
                      : std::string();
}

// Adds checks for values that CLI11 accepts: non-finite numbers, negative
// unsigned numbers and empty text.
void ThrowOnInvalidNumbers(CLI::App* app) {
  for (CLI::Option* option : app->get_options()) {
    const std::string type = option->get_type_name();
    const bool may_be_empty =
        option->check_name("--name") || option->check_name("--serial");
    if (type.rfind("FLOAT", 0) == 0)
      option->check(CLI::Validator(ExplainNonFinite, ""));
    else if (type.rfind("UINT", 0) == 0)
      option->check(CLI::Validator(ExplainNegative, ""));
    else if (option->get_expected_max() > 0 && !may_be_empty)
      option->check(CLI::Validator(ExplainEmpty, ""));
  }
  for (CLI::App* command : app->get_subcommands({}))
    ThrowOnInvalidNumbers(command);
}

// Opens closed standard streams, so that files opened later do not become
// standard output. Output to a closed stream then fails, and messages are
// discarded.
void OccupyStandardStreams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) < 0)
      open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY);
}

// Throws if the first argument is not a command.
void RequireCommand(const CLI::App& app, const std::string& word) {
  std::string nearest;
  size_t fewest = 3;  // a similar command has fewer edits
  for (const CLI::App* command : app.get_subcommands({})) {
    const std::string& name = command->get_name();
    if (name == word) return;
    const size_t edits = CountEdits(word, name);
    if (edits >= fewest || edits >= name.size()) continue;
    fewest = edits;
    nearest = name;
  }
  if (word == "capture")
    throw Error(ExitCode::kUsage,
                "capture: not in this build; build with libmicrohttpd and "
                "libjpeg, or install the Debian package raygrid-capture");
  if (word == "simulate" || word == "experiment")
    throw Error(
        ExitCode::kUsage,
        word + ": not in this build; configure with -DRAYGRID_EXPERIMENTS=ON");
  throw Error(
      ExitCode::kUsage,
      fmt::format("{}: unknown command; {}", word,
                  nearest.empty() ? "raygrid --help lists them"
                                  : fmt::format("did you mean {}?", nearest)));
}

bool IsOutputLost() {
  return std::fflush(stdout) != 0 || std::ferror(stdout) != 0;
}

int FailToPrint() {
  return Fail(ExitCode::kOutputFailed,
              "cannot write to standard output; results are in the output "
              "files only, if any");
}

int Run(int argc, char** argv) {
  CLI::App app(
      "Camera calibration with B-spline generic models, undistortion on the "
      "device.");
  app.name("raygrid");
  app.formatter(std::make_shared<HelpFormatter>());
  app.get_help_ptr()->description("print this help");
  app.set_version_flag("--version", "raygrid " RAYGRID_VERSION,
                       "print the version");
  app.require_subcommand(1);
  app.footer(
      "raygrid COMMAND --help describes the options of a command; see also\n"
      "tools/README.md and the manual pages.\n\n" +
      ExitCodesHelp());
  CommonOptions common;
#define RAYGRID_COMMAND(title, Name) \
  Add##Name(&app, &common);          \
  app.get_subcommands({}).back()->group(#title);
#include "command_list.inc"
#undef RAYGRID_COMMAND
  ThrowOnInvalidNumbers(&app);
  if (argc > 1 && argv[1][0] != '-') RequireCommand(app, argv[1]);
  try {
    std::vector<std::string> words =
        CurrentOptionNames({argv + 1, argv + argc});
    std::reverse(words.begin(), words.end());  // the order that CLI11 expects
    app.parse(words);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::RuntimeError& error) {
    return error.get_exit_code();
  } catch (const CLI::ParseError& error) {
    const bool has_command = argc > 1 && argv[1][0] != '-';
    return Fail(
        ExitCode::kUsage,
        fmt::format("{}; see raygrid{}{} --help", error.what(),
                    has_command ? " " : "", has_command ? argv[1] : ""));
  }
  return 0;
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  // Eigen chooses the order of summation by cache sizes; fixed sizes make
  // results identical on all machines.
  Eigen::setCpuCacheSizes(32 << 10, 512 << 10, 4 << 20);
  raygrid::RetainFreedMemory();
  raygrid::OccupyStandardStreams();
  std::signal(SIGXFSZ, SIG_IGN);  // too large files then cause EFBIG
  try {
    const int code = raygrid::Run(argc, argv);
    return code == 0 && raygrid::IsOutputLost() ? raygrid::FailToPrint() : code;
  } catch (const raygrid::Error& error) {
    return raygrid::Fail(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    return raygrid::Fail(raygrid::ExitCode::kInvalidInput,
                         "not enough memory for this input");
  } catch (const std::exception& error) {
    if (raygrid::IsOutputLost()) return raygrid::FailToPrint();
    return raygrid::Fail(raygrid::ExitCode::kInvalidInput, error.what());
  }
}
