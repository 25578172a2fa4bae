#include "calibration/operating_point_check.h"

#include <gtest/gtest.h>

namespace raygrid {
namespace {

std::string TextOf(double min_detectable_error) {
  return UncertainOperatingParameter{OperatingParameter::kTemperature, 50, 16,
                                     min_detectable_error, 10}
      .Text();
}

TEST(UncertainOperatingParameter, SaysWhichWrongValuesAreDetected) {
  EXPECT_NE(TextOf(30).find("a single wrong value is detected only if its "
                            "error exceeds 30 °C"),
            std::string::npos);
  EXPECT_NE(TextOf(140).find("single wrong values cannot be detected"),
            std::string::npos);
}

}  // namespace
}  // namespace raygrid
