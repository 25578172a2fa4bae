#include "evaluation/rounded_text.h"

#include <gtest/gtest.h>

namespace raygrid {
namespace {

TEST(RoundedText, EstimatesHaveTheDigitsOfTheirDeviation) {
  EXPECT_EQ(WithDeviation(120.04123, 0.02349), "120.041 +- 0.023");
  EXPECT_EQ(WithDeviation(-0.5, 0.000123, " &plusmn; "),
            "-0.50000 &plusmn; 0.00012");
  EXPECT_EQ(WithDeviation(1234.5, 56.7), "1234 +- 57");
  EXPECT_EQ(WithDeviation(1234.5, 567.8), "1234 +- 568");
  EXPECT_EQ(WithDeviation(2, 0), "2.00 +- 0.00");
}

TEST(RoundedText, FiguresHaveThreeDigits) {
  EXPECT_EQ(ThreeDigits(0.038274), "0.0383");
  EXPECT_EQ(ThreeDigits(12.345), "12.3");
  EXPECT_EQ(ThreeDigits(1234.4), "1234");
  EXPECT_EQ(ThreeDigits(-0.5), "-0.500");
  EXPECT_EQ(ThreeDigits(0), "0.000");
}

}  // namespace
}  // namespace raygrid
