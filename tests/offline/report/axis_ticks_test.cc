#include "report/axis_ticks.h"

#include <cmath>

#include "support.h"

namespace raygrid {
namespace {

TEST(MakeTicks, AreRoundAndWithinTheRange) {
  EXPECT_EQ(MakeTicks(529.8, 554.5),
            (std::vector<double>{530, 535, 540, 545, 550}));
  EXPECT_EQ(MakeTicks(0, 10), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  for (const auto& [low, high] :
       {std::pair(-1.93, 1.61), std::pair(1234.56, 1234.59),
        std::pair(-3e-6, 4e-6), std::pair(20.0, 70.0)}) {
    const std::vector<double> ticks = MakeTicks(low, high);
    ASSERT_GE(ticks.size(), 3u) << low;
    EXPECT_LE(ticks.size(), 8u) << low;
    const double step = ticks[1] - ticks[0];
    const double digit =
        step / std::pow(10, std::floor(std::log10(step * 1.0001)));
    EXPECT_TRUE(std::abs(digit - 1) < 1e-3 || std::abs(digit - 2) < 1e-3 ||
                std::abs(digit - 5) < 1e-3)
        << step;
    EXPECT_GE(ticks.front(), low);
    EXPECT_LE(ticks.back(), high);
    EXPECT_NEAR(ticks[0] / step, std::round(ticks[0] / step), 1e-3);
  }
}

TEST(RoundUp, IsNoLessThanTheValue) {
  EXPECT_EQ(RoundUp(0.4), 0.5);
  EXPECT_EQ(RoundUp(3), 3);
  EXPECT_EQ(RoundUp(80), 100);
}

}  // namespace
}  // namespace raygrid
