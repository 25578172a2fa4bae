#include "evaluation/rounded_text.h"

#include <gtest/gtest.h>

namespace raygrid {
namespace {

TEST(RoundedText, EstimatesHaveTheDigitsOfTheirDeviation) {
  EXPECT_EQ(FormatWithStdDev(120.04123, 0.02349), "120.041 ± 0.023");
  EXPECT_EQ(FormatWithStdDev(-0.5, 0.000123, " &plusmn; "),
            "-0.50000 &plusmn; 0.00012");
  EXPECT_EQ(FormatWithStdDev(1234.5, 56.7), "1234 ± 57");
  EXPECT_EQ(FormatWithStdDev(1234.5, 567.8), "1234 ± 568");
  EXPECT_EQ(FormatWithStdDev(2, 0), "2.00 ± 0.00");
}

TEST(RoundedText, FiguresHaveThreeDigits) {
  EXPECT_EQ(FormatThreeDigits(0.038274), "0.0383");
  EXPECT_EQ(FormatThreeDigits(12.345), "12.3");
  EXPECT_EQ(FormatThreeDigits(1234.4), "1234");
  EXPECT_EQ(FormatThreeDigits(-0.5), "-0.500");
  EXPECT_EQ(FormatThreeDigits(0), "0.000");
}

}  // namespace
}  // namespace raygrid
