/// A person before the emulated camera: plays to the outline of a capture's
/// page, by orders on standard output that tests/camera/emulated_frames.h has.
///   play_to_outline PORT HOST TOKEN LENS WIDTHxHEIGHT BOARD UNPLUG_AT
///   FINISH_AT
/// When so many frames are kept the camera is unplugged. It is plugged in again
/// once the page has gone. It ends when the page says done, or after it asked
/// the page to finish with so many frames, with a line on standard error.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "capture_operator.h"
#include "simulation/simulated_camera_models.h"
#include "target/board_spec.h"

namespace raygrid {
namespace {

constexpr int kPatientStates = 8;

void Order(char letter, const std::vector<uint8_t>& bytes = {}) {
  std::fputc(letter, stdout);
  std::fwrite(bytes.data(), 1, bytes.size(), stdout);
  if (std::fflush(stdout) != 0) std::exit(1);  // the camera has gone
}

std::vector<uint8_t> MakeYuyv(const std::vector<uint8_t>& grey) {
  std::vector<uint8_t> yuyv(2 * grey.size(), 128);
  for (size_t i = 0; i < grey.size(); ++i) yuyv[2 * i] = grey[i];
  return yuyv;
}

struct Address {
  uint16_t port;
  std::string fields;  // of a request
};

class Performance {
 public:
  // Numbers of kept frames; 0: never.
  Performance(CaptureOperator* person, size_t unplug_at, size_t finish_at)
      : person_(person), unplug_at_(unplug_at), finish_at_(finish_at) {}

  bool is_over() const { return is_over_; }

  // Until the page goes.
  void Follow(const Address& address) {
    HttpClient page(address.port, "GET /state", address.fields);
    while (const auto state = NextState(&page)) {
      const auto picture = person_->Look(*state);
      const bool should_accept =
          finish_at_ > 0 && person_->num_kept() >= finish_at_;
      is_over_ = person_->is_done() || should_accept;
      if (should_accept)
        HttpClient(address.port, "POST /finish", address.fields).Status();
      if (is_over_) return;
      if (unplug_at_ > 0 && person_->num_kept() >= unplug_at_) {
        unplug_at_ = 0;
        is_unplugged_ = true;
        Order('u');
      } else if (picture && !is_unplugged_) {
        Order('f', MakeYuyv(*picture));
      }
    }
    if (is_unplugged_) Order('p');
    is_unplugged_ = false;
  }

 private:
  CaptureOperator* const person_;
  size_t unplug_at_;
  const size_t finish_at_;
  bool is_unplugged_ = false, is_over_ = false;
};

int Run(char** argv) {
  const std::string size = argv[5];
  const size_t cross = size.find('x');
  const auto camera = MakeSimulatedCamera(
      argv[4],
      {std::atoi(size.c_str()), std::atoi(size.substr(cross + 1).c_str())});
  const Pattern pattern = ReadPatternOrSpec(argv[6]);
  CaptureOperator person(*camera, pattern.boards.front(), kPatientStates);
  Performance performance(&person, std::strtoul(argv[7], nullptr, 10),
                          std::strtoul(argv[8], nullptr, 10));
  const Address address = {static_cast<uint16_t>(std::atoi(argv[1])),
                           std::string("Host: ") + argv[2] +
                               "\r\nAuthorization: Bearer " + argv[3] + "\r\n"};
  while (!performance.is_over()) {
    performance.Follow(address);
    // A port that nobody listens at answers at once.
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  std::fprintf(stderr, "%zu frames kept of %d views\n", person.num_kept(),
               person.num_views());
  return 0;
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) { return argc == 9 ? raygrid::Run(argv) : 2; }
