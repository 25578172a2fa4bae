// raygrid-capture: captures calibration images from a live camera.
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "camera_error.h"
#include "camera_session.h"
#include "capture_arguments.h"
#include "capture_json.h"
#include "capture_loop.h"
#include "capture_page.h"
#include "capture_report.h"
#include "dataset/error.h"
#include "dataset/memory_retention.h"
#include "dataset/text_encoding.h"
#include "help_formatter.h"
#include "pattern_input.h"
#include "sibling_program.h"
#include "side_by_side.h"

namespace raygrid {
namespace {

// Prints states: as lines of JSON when something changes, on a terminal as a
// block a few times per second, otherwise as a line for each kept frame.
class StandardOutput {
 public:
  explicit StandardOutput(const CaptureArguments& arguments)
      : is_json_(arguments.common.json),
        is_quiet_(arguments.common.quiet),
        is_terminal_(isatty(STDERR_FILENO) == 1) {}

  void Show(const CaptureState& state) {
    const bool is_new = state.word != word_ || state.hint != hint_ ||
                        state.kept.size() != num_kept_;
    // Frames of a resumed session are not reported again.
    const bool is_kept = state.word == "kept" && state.kept.size() > num_kept_;
    word_ = state.word;
    hint_ = state.hint;
    num_kept_ = state.kept.size();
    if (is_json_) {
      if (is_new) {
        fmt::print("{}\n", CaptureJson(state));
        std::fflush(stdout);
      }
    } else if (!is_quiet_ && is_terminal_) {
      PrintStateBlock(state);
    } else if (!is_quiet_ && is_kept) {
      fmt::print(
          stderr, "{}: kept{}; next: {}\n", state.kept.back(),
          state.stddev_px > 0
              ? fmt::format(", uncertainty before it {:.2g} px{}",
                            state.stddev_px,
                            state.stddev_is_floor ? " (lower bound)" : "")
              : "",
          state.hint);
    }
  }

 private:
  // Overwrites the previous block.
  void PrintStateBlock(const CaptureState& state) {
    constexpr std::chrono::milliseconds kPause(200);
    const auto now = std::chrono::steady_clock::now();
    if (num_lines_ > 0 && now - shown_ < kPause && !state.is_done) return;
    shown_ = now;
    winsize window = {};
    int columns = 60;
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 12)
      columns = std::min(columns, window.ws_col - 2);
    const std::string text = DrawState(state, columns);
    std::string block =
        num_lines_ > 0 ? fmt::format("\x1b[{}A\x1b[J", num_lines_) : "";
    block += text;
    num_lines_ = static_cast<int>(std::count(text.begin(), text.end(), '\n'));
    std::fputs(block.c_str(), stderr);
  }

  const bool is_json_, is_quiet_, is_terminal_;
  std::string word_, hint_;
  size_t num_kept_ = 0;
  int num_lines_ = 0;
  std::chrono::steady_clock::time_point shown_;
};

// Starts the page of a session for everyone with the link.
std::unique_ptr<CapturePage> MakePage(const CaptureArguments& arguments,
                                      const SessionFolder& session,
                                      CaptureRequests* wishes) {
  const auto follow = [wishes](const CaptureCommand& command) {
    switch (command.kind) {
      case CaptureCommand::Kind::kPause:
        return wishes->Pause(true);
      case CaptureCommand::Kind::kGoOn:
        return wishes->Pause(false);
      case CaptureCommand::Kind::kUndo:
        return wishes->Undo();
      case CaptureCommand::Kind::kFinish:
        return wishes->Finish();
      case CaptureCommand::Kind::kDelete:
        return wishes->Delete(command.name);
    }
  };
  const auto read = [&session](const std::string& name, GreyBuffer* picture) {
    try {
      std::vector<GreyImage> greys;
      for (size_t c = 0; c < session.cameras().size(); ++c)
        if (const std::string path = session.MakePath(c, name);
            std::filesystem::exists(path))
          greys.push_back(MakeGreyImage(ReadImage(path, true)));
      std::vector<const GreyImage*> shown;
      for (const GreyImage& grey : greys) shown.push_back(&grey);
      *picture = ConcatenateHorizontally(shown);
      return !greys.empty();
    } catch (const std::exception&) {
      return false;
    }
  };
  auto page = std::make_unique<CapturePage>(
      arguments.page,
      PageOptionNames{"raygrid capture", "--listen", "--port", "--page-name"},
      follow, read);
  if (!arguments.common.quiet || page->has_new_token())
    fmt::print(stderr, "{}\n", page->link());
  return page;
}

void PrintResult(const CaptureArguments& arguments, const CaptureState& state) {
  if (arguments.common.quiet) return;
  for (const std::string& warning : state.warnings)
    fmt::print(stderr, "raygrid-capture: {}\n", Printable(warning));
  if (arguments.common.json) return;
  fmt::print("{} {} kept in {}{}\n", state.kept.size(),
             state.cameras.empty() ? "frames" : "synchronized frames",
             arguments.output,
             state.stddev_px > 0
                 ? fmt::format("; uncertainty {:.2g} px in 95 % of the image{}",
                               state.stddev_px,
                               state.stddev_is_floor ? " (lower bound)" : "")
                 : "");
}

void RequireFrames(const CaptureArguments& arguments,
                   const CaptureState& state) {
  if (!state.kept.empty()) return;
  throw Error(
      ExitCode::kInsufficientData,
      fmt::format("no frame was kept, the last one because '{}'{}; check that "
                  "the board matches {}",
                  state.word, state.hint.empty() ? "" : " (" + state.hint + ")",
                  arguments.pattern));
}

int Run(int argc, char** argv) {
  CLI::App app("Capture calibration images live, guided by coverage.");
  app.name("raygrid capture");
  app.formatter(std::make_shared<HelpFormatter>());
  CaptureArguments arguments;
  AddCaptureOptions(&app, &arguments);
  app.footer(
      "Example:\n  raygrid capture --source v4l2:/dev/video0 --pattern "
      "pattern.yaml -o session/");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    throw Error(ExitCode::kUsage,
                std::string(error.what()) + "; see raygrid capture --help");
  }
  FinishCaptureArguments(&arguments);
  const Pattern pattern =
      LoadCheckedPattern(arguments.pattern, arguments.common);
  InstallSignalHandlers();
  const auto frames = OpenFrames(arguments);
  if (!frames) return 0;
  // With existing photographs and videos, no operator follows suggestions.
  constexpr double kMaxFractionWithoutOperator = 0.15;
  if (!frames->is_live())
    arguments.loop.guide.min_gain_ratio = kMaxFractionWithoutOperator;
  SessionFolder session(arguments.output, pattern, frames->names(),
                        arguments.resume);
  StandardOutput output(arguments);
  CaptureRequests wishes;
  std::unique_ptr<CapturePage> page;
  if (frames->is_live() && !arguments.no_page)
    page = MakePage(arguments, session, &wishes);
  CaptureViewers viewers;
  viewers.show = [&output, &page](const CaptureState& state) {
    output.Show(state);
    if (page) page->Show(state);
  };
  if (page) {
    viewers.show_picture = [&page](const GreyImage& grey) {
      page->ShowImage(grey.bytes.data(), grey.size.width, grey.size.height,
                      static_cast<size_t>(grey.size.width));
    };
    viewers.add_kept = [&page](const std::string& name,
                               const std::vector<const GreyImage*>& greys) {
      const GreyBuffer picture = ConcatenateHorizontally(greys);
      page->AddKept(name, picture.bytes.data(), picture.width, picture.height,
                    static_cast<size_t>(picture.width));
    };
  }
  CaptureLoop loop(arguments.loop, pattern, frames.get(), &session, viewers,
                   &wishes);
  loop.Run();
  RequireFrames(arguments, loop.state());
  PrintResult(arguments, loop.state());
  if (arguments.no_calibrate || IsSignalled()) return 0;
  page.reset();  // informs the clients of the end
  std::vector<std::string> calibrate = {
      "calibrate", arguments.output, "--threads",
      std::to_string(arguments.common.threads)};
  if (arguments.loop.frame_selector.every_frame)
    calibrate.emplace_back("--rolling-shutter");
  if (arguments.common.quiet) calibrate.emplace_back("--quiet");
  if (arguments.common.json) calibrate.emplace_back("--json");
  return ExecSiblingProgram("raygrid", calibrate);
}

int Fail(int code, const std::string& message) {
  fmt::print(stderr, "raygrid-capture: {}\n", Printable(message));
  return code;
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  // Fixed cache sizes make Eigen's order of summation, and results, identical
  // on all machines.
  Eigen::setCpuCacheSizes(32 << 10, 512 << 10, 4 << 20);
  raygrid::RetainFreedMemory();
  try {
    return raygrid::Run(argc, argv);
  } catch (const raygrid::Error& error) {
    return raygrid::Fail(static_cast<int>(error.code()), error.what());
  } catch (const raygrid::CameraError& error) {
    return raygrid::Fail(static_cast<int>(error.code()), error.what());
  } catch (const std::bad_alloc&) {
    return raygrid::Fail(2, "not enough memory for this input");
  } catch (const std::exception& error) {
    return raygrid::Fail(2, error.what());
  }
}
