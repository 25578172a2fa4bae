// The page of a capture with a drawn board, for tests and for those who change
// the page:
//
//   capture_page_demo [ADDRESS [PORT]]
//
// Prints the link, then each command that the page sends. Reads lines:
//
//   word WORD HINT   keep NAME   known FACTOR   next   done   remark TEXT
//   rig              two cameras, the first one shown
//   picture SECONDS  one picture, of the board at that time
//   live             pictures from now on, 20 a second
//   quit             so does the end of the input
#include <Eigen/LU>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>

#include "camera_error.h"
#include "capture_page.h"

namespace raygrid {
namespace {

constexpr int kWidth = 960, kHeight = 720;
constexpr int kColumns = 9, kRows = 6;  // of corners
constexpr double kSquare_px = 42;

// The board at a time: middle, turn, and how far it is tilted.
struct DrawnBoard {
  Eigen::Vector2d middle;
  Eigen::Matrix2d turn;
  double tilt = 0;

  static DrawnBoard At(double seconds) {
    const double angle = 0.35 * std::sin(0.7 * seconds);
    DrawnBoard board;
    board.middle = {420 + 180 * std::cos(0.5 * seconds),
                    350 + 90 * std::sin(0.9 * seconds)};
    board.turn << std::cos(angle), -std::sin(angle), std::sin(angle),
        std::cos(angle);
    board.turn *= kSquare_px * (1 + 0.2 * std::sin(0.4 * seconds));
    board.tilt = 0.05 * std::sin(0.6 * seconds);
    return board;
  }
  // A place of the board, in squares from its middle, to pixels and back.
  Eigen::Vector2d Pixel(const Eigen::Vector2d& place) const {
    return middle + turn * place / (1 + tilt * place.x());
  }
  Eigen::Vector2d Place(const Eigen::Vector2d& pixel) const {
    const Eigen::Vector2d offset = pixel - middle;
    Eigen::Matrix2d equations = turn;
    equations.col(0) -= tilt * offset;
    return equations.inverse() * offset;
  }
  std::vector<Eigen::Vector2d> Outline() const {
    const double x = (kColumns + 1) / 2.0, y = (kRows + 1) / 2.0;
    return {Pixel({-x, -y}), Pixel({x, -y}), Pixel({x, y}), Pixel({-x, y})};
  }
  std::vector<Eigen::Vector2d> Corners() const {
    std::vector<Eigen::Vector2d> corners;
    for (int row = 0; row < kRows; ++row)
      for (int column = 0; column < kColumns; ++column)
        corners.push_back(
            Pixel({column - (kColumns - 1) / 2.0, row - (kRows - 1) / 2.0}));
    return corners;
  }
  std::vector<uint8_t> Draw() const {
    std::vector<uint8_t> grey(size_t{kWidth} * kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const Eigen::Vector2d place =
            Place({x, y}).array() + Eigen::Array2d(kColumns + 1, kRows + 1) / 2;
        uint8_t& to = grey[size_t(y) * kWidth + size_t(x)];
        to = static_cast<uint8_t>(60 + 50 * y / kHeight + 20 * x / kWidth);
        if (place.x() < -0.4 || place.x() > kColumns + 1.4 ||
            place.y() < -0.4 || place.y() > kRows + 1.4)
          continue;
        const bool is_on_board = place.x() > 0 && place.x() < kColumns + 1 &&
                                 place.y() > 0 && place.y() < kRows + 1;
        const bool is_dark =
            (int(std::floor(place.x())) + int(std::floor(place.y()))) % 2 == 0;
        to = is_on_board && is_dark ? 30 : 215;
      }
    return grey;
  }
};

class Demo {
 public:
  explicit Demo(const PageAddress& address)
      : page_(
            address, {"capture_page_demo"},
            [this](const CaptureCommand& command) { OnCommand(command); },
            [](const std::string& name, GreyBuffer* picture) {
              return Read(name, picture);
            }) {
    state_.width = kWidth;
    state_.height = kHeight;
    state_.hint = "Show the board to the camera";
    std::printf("%s\n", page_.link().c_str());
    std::fflush(stdout);
  }
  ~Demo() {
    is_live_ = false;
    if (pictures_.joinable()) pictures_.join();
  }

  void Run() {
    std::string line;
    while (std::getline(std::cin, line)) {
      std::istringstream words(line);
      std::string verb, rest;
      words >> verb >> std::ws;
      std::getline(words, rest);
      if (verb == "quit") return;
      Do(verb, rest);
    }
  }

 private:
  // Names of numbers have a picture: the board at that time.
  static bool Read(const std::string& name, GreyBuffer* picture) {
    if (name.empty() || name.find("lost") != std::string::npos) return false;
    *picture = {kWidth, kHeight, DrawnBoard::At(double(name.size())).Draw()};
    return true;
  }

  void Do(const std::string& verb, const std::string& rest) {
    std::istringstream words(rest);
    double number = 0;
    if (verb == "live" && !pictures_.joinable())
      pictures_ = std::thread([this] { ShowPictures(); });
    if (verb == "keep") {
      const auto grey = DrawnBoard::At(double(rest.size())).Draw();
      page_.AddKept(rest, grey.data(), kWidth, kHeight, kWidth);
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    if (verb == "word") {
      words >> state_.word >> std::ws;
      std::getline(words, state_.hint);
    } else if (verb == "keep") {
      state_.kept.push_back(rest);
      state_.num_expected = std::max(0, 15 - int(state_.kept.size()));
    } else if (verb == "known" && words >> number) {
      MakeKnown(number);
    } else if (verb == "next") {
      state_.next = {{DrawnBoard::At(7).Outline(), {}}};
      const auto& outline = state_.next[0].outline;
      state_.next[0].top = {outline[0], outline[1]};
    } else if (verb == "done") {
      state_.is_done = true;
      state_.num_expected = 0;
    } else if (verb == "rig") {
      state_.camera = "left";
      state_.cameras = {{"left", "moving", 0.04}, {"right", "kept", 0.2}};
      state_.links = {{"left", "right", 0.013}};
    } else if (verb == "remark") {
      state_.warnings.push_back(rest);
    } else if (verb == "picture" && words >> number) {
      ShowImage(number);
    }
    page_.Show(state_);
  }

  void MakeKnown(double factor) {
    state_.places.clear();
    for (int y = 0; y < 9; ++y)
      for (int x = 0; x < 12; ++x) {
        const Eigen::Vector2d pixel((x + 0.5) * kWidth / 12 - 0.5,
                                    (y + 0.5) * kHeight / 9 - 0.5);
        const double far = (pixel - Eigen::Vector2d(400, 330)).norm() / 300;
        state_.places.push_back({pixel, factor * 0.05 * (1 + far * far * far)});
      }
    state_.stddev_px = 0.4 * factor;
    state_.target_px = 0.2;
    state_.sharpness_px = 2.1;
    state_.brightness = 0.78;
    state_.frames_per_second = 19.6;
  }

  // The mutex is held.
  void ShowImage(double seconds) {
    const DrawnBoard board = DrawnBoard::At(seconds);
    const auto grey = board.Draw();
    page_.ShowImage(grey.data(), kWidth, kHeight, kWidth);
    state_.features = board.Corners();
    state_.arrow.clear();
    if (!state_.next.empty())
      state_.arrow = {board.middle, DrawnBoard::At(7).middle};
  }

  void ShowPictures() {
    for (int k = 0; is_live_; ++k) {
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        ShowImage(0.05 * k);
        page_.Show(state_);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }

  void OnCommand(const CaptureCommand& command) {
    constexpr const char* kNames[] = {"pause", "go-on", "undo", "finish",
                                      "delete"};
    std::printf("%s%s%s\n", kNames[int(command.kind)],
                command.name.empty() ? "" : " ", command.name.c_str());
    std::fflush(stdout);
    const std::lock_guard<std::mutex> lock(mutex_);
    using Kind = CaptureCommand::Kind;
    auto& kept = state_.kept;
    if (command.kind == Kind::kPause || command.kind == Kind::kGoOn)
      state_.is_paused = command.kind == Kind::kPause;
    if (command.kind == Kind::kUndo && !kept.empty()) kept.pop_back();
    if (command.kind == Kind::kDelete)
      for (size_t i = kept.size(); i-- > 0;)
        if (kept[i] == command.name)
          kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(i));
    page_.Show(state_);
  }

  std::mutex mutex_;
  CaptureState state_;
  std::atomic<bool> is_live_{true};
  CapturePage page_;
  std::thread pictures_;
};

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  raygrid::PageAddress address;
  if (argc > 1) address.number = argv[1];
  if (argc > 2) address.port = static_cast<uint16_t>(std::stoi(argv[2]));
  try {
    raygrid::Demo(address).Run();
  } catch (const raygrid::CameraError& error) {
    std::fprintf(stderr, "capture_page_demo: %s\n", error.what());
    return 1;
  }
}
