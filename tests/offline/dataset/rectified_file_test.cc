#include "dataset/rectified_file.h"

#include "support.h"

namespace raygrid {
namespace {

constexpr char kPair[] =
    "left: \"a\"\nright: \"b\"\norientation: horizontal\nbaseline: 0.1\n"
    "image_size: [320, 240]\n"
    "P1:\n  - [150, 0, 160, 0]\n  - [0, 150, 120, 0]\n  - [0, 0, 1, 0]\n"
    "P2:\n  - [150, 0, 160, -15]\n  - [0, 150, 120, 0]\n  - [0, 0, 1, 0]\n"
    "raygrid_rectified: 1\n";

std::string PairWith(const std::string& old, const std::string& by) {
  std::string text = kPair;
  return text.replace(text.find(old), old.size(), by);
}

TEST(RectifiedFile, IsRead) {
  const RectifiedFile file = ParseRectifiedFile("f", kPair);
  EXPECT_EQ(file.names[1], "b");
  EXPECT_EQ(file.size, (ImageSize{320, 240}));
  EXPECT_EQ(file.p[1](0, 3), -15);
  EXPECT_EQ(file.p[0](1, 2), 120);
}

TEST(RectifiedFile, SaysWhatIsWrong) {
  for (const auto& [old, by, word] : std::vector<std::array<const char*, 3>>{
           {"raygrid_rectified: 1", "raygrid_rectified: 2", "no 'raygrid"},
           {"[320, 240]", "[320]", "image_size"},
           {"[320, 240]", "[320, x]", "line 5"},
           {"P2:", "P3:", "P2"},
           {"- [0, 150, 120, 0]", "- [0, .nan, 120, 0]", "P1"},
           {"- [150, 0, 160, -15]", "- [150, 0, 160]", "P2"},
           {"- [150, 0, 160, -15]", "- [-150, 0, 160, 0]", "P2"}})
    ExpectError(ExitCode::kInvalidInput, {"f", word}, [&, &o = old, &b = by] {
      ParseRectifiedFile("f", PairWith(o, b));
    });
}

}  // namespace
}  // namespace raygrid
