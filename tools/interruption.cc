#include "interruption.h"

#include <unistd.h>

#include <atomic>
#include <csignal>

namespace raygrid {
namespace {

std::atomic<bool> is_interrupted{false};
std::atomic<bool> has_listener{false};
std::atomic<int> interruption{0};  // the number of the received signal
static_assert(std::atomic<int>::is_always_lock_free &&
                  std::atomic<bool>::is_always_lock_free,
              "a signal handler may write it");

void StopWithoutListener(int) {
  if (!has_listener) raise(interruption);
}

void HandleSignal(int number) {
  constexpr unsigned kPatienceS = 1;
  interruption = number;
  is_interrupted = true;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  alarm(kPatienceS);
}

}  // namespace

void InstallInterruptHandler() {
  struct sigaction action = {};
  action.sa_handler = HandleSignal;
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  action.sa_handler = StopWithoutListener;
  sigaction(SIGALRM, &action, nullptr);
}

bool IsInterrupted() {
  if (!is_interrupted) return false;
  has_listener = true;
  return true;
}

void IgnoreFirstSignal() { has_listener = true; }

}  // namespace raygrid
