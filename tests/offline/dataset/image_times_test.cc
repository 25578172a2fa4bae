#include "dataset/image_times.h"

#include "support.h"

namespace raygrid {
namespace {

std::string RefusalOf(const std::string& text) {
  try {
    ParseImageTimes("times.csv", text);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(ImageTimes, AreReadAsTheyAreWritten) {
  const ImageTimes times = {
      {"a.png", 0.1}, {"b, c.png", 1e-5}, {"d.png", 1700000000.0333333}};
  EXPECT_EQ(ParseImageTimes("times.csv", FormatImageTimes(times)), times);
}

TEST(ImageTimes, ThatCannotBeAreRefused) {
  for (const auto& [text, why] :
       {std::pair("", "times.csv"),
        std::pair("image,time_s\n", "contains no images"),
        std::pair("image,seconds\na.png,1\n", "time_s"),
        std::pair("image,time_s\na.png,1\na.png,2\n",
                  "line 3: duplicate image a.png"),
        std::pair("image,time_s\na.png,1\nb.png,1\n",
                  "b.png and a.png have the same timestamp"),
        std::pair("image,time_s\na.png,now\n", "line 2"),
        std::pair("image,time_s\na.png,inf\n", "line 2")})
    EXPECT_NE(RefusalOf(text).find(why), std::string::npos)
        << text << RefusalOf(text);
}

}  // namespace
}  // namespace raygrid
