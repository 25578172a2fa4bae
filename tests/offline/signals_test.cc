#include <unistd.h>

#include <csignal>

#include "interruption.h"
#include "support.h"

namespace raygrid {
namespace {

// A child's signal handlers, and its end, are its own.
class Interruptions : public testing::Test {
 protected:
  void SetUp() override { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};
using InterruptionsDeathTest = Interruptions;

void Interrupt(int signal) {
  InstallInterruptHandler();
  std::raise(signal);
}

// Sleeps that signals do not end.
void WorkFor(int seconds) {
  for (unsigned left = seconds; left > 0;) left = sleep(left);
}

TEST_F(InterruptionsDeathTest, WorkThatDoesNotHearIsEndedAfterASecond) {
  for (const int signal : {SIGINT, SIGTERM})
    EXPECT_EXIT(
        {
          Interrupt(signal);
          WorkFor(20);
        },
        testing::KilledBySignal(signal), "");
}

TEST_F(InterruptionsDeathTest, WorkThatHearsGoesOnToItsEnd) {
  EXPECT_EXIT(
      {
        Interrupt(SIGTERM);
        if (!IsInterrupted()) std::exit(1);
        WorkFor(2);
        std::exit(7);
      },
      testing::ExitedWithCode(7), "");
}

TEST_F(InterruptionsDeathTest, WhatIsBeingWrittenIsWrittenToItsEnd) {
  EXPECT_EXIT(
      {
        InstallInterruptHandler();
        IgnoreFirstSignal();
        std::raise(SIGTERM);
        WorkFor(2);
        std::exit(7);
      },
      testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace raygrid
