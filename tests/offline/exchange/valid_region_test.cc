#include "exchange/valid_region.h"

#include <string>

#include "support.h"

namespace raygrid {
namespace {

// Cells of 4 pixels; the last column and row are cut by the image's edge.
constexpr ImageSize kRegionImage = {22, 14};

ValidityMask MaskOf(const std::vector<std::string>& rows) {
  ValidityMask mask = ValidityMask::Over(kRegionImage);
  mask.is_valid.clear();
  for (const std::string& row : rows)
    for (const char cell : row) mask.is_valid.push_back(cell == '#');
  return mask;
}

std::vector<bool> ThereAndBack(const ValidityMask& mask) {
  return MakeValidityMask(ComputeValidRegion(mask, kRegionImage), kRegionImage)
      .is_valid;
}

TEST(ValidRegion, GoesAlongTheEdgesOfCells) {
  const ValidityMask mask = MaskOf({"......",  //
                                    ".##...",  //
                                    ".#....",  //
                                    "......"});
  EXPECT_EQ(ComputeValidRegion(mask, kRegionImage), (ValidRegion{{3.5, 3.5},
                                                                 {11.5, 3.5},
                                                                 {11.5, 7.5},
                                                                 {7.5, 7.5},
                                                                 {7.5, 11.5},
                                                                 {3.5, 11.5},
                                                                 {3.5, 3.5}}));
}

TEST(ValidRegion, EndsWithTheImage) {
  const ValidityMask all = MaskOf({"######", "######", "######", "######"});
  EXPECT_EQ(ComputeValidRegion(all, kRegionImage), (ValidRegion{{-0.5, -0.5},
                                                                {21.5, -0.5},
                                                                {21.5, 13.5},
                                                                {-0.5, 13.5},
                                                                {-0.5, -0.5}}));
  EXPECT_EQ(ThereAndBack(all), all.is_valid);
}

TEST(ValidRegion, OfOnePartComesBack) {
  for (const auto& rows :
       {std::vector<std::string>{"..##..", ".####.", "..####", "...#.#"},
        {"......", "......", "......", ".....#"},
        {"#.....", "######", "#.#.#.", "#.#.##"},
        // The outline meets itself at a corner.
        {"..###.", "..#.#.", ".#.##.", ".###.."}}) {
    const ValidityMask mask = MaskOf(rows);
    EXPECT_EQ(ThereAndBack(mask), mask.is_valid) << rows[0];
    const RegionLoss loss = ComputeRegionLoss(mask, kRegionImage);
    EXPECT_EQ(loss.num_left_out + loss.num_held, 0);
  }
}

TEST(ValidRegion, IsThatOfTheLargestPartWithoutItsHoles) {
  const ValidityMask mask = MaskOf({"#.###.",  //
                                    ".##.#.",  //
                                    "..###.",  //
                                    ".....#"});
  EXPECT_EQ(ThereAndBack(mask), MaskOf({"..###.",  //
                                        ".####.",  //
                                        "..###.",  //
                                        "......"})
                                    .is_valid);
  const RegionLoss loss = ComputeRegionLoss(mask, kRegionImage);
  EXPECT_EQ(loss.num_left_out, 2);
  EXPECT_EQ(loss.num_held, 1);
}

TEST(ValidRegion, HasNoPointIfNothingIsTrusted) {
  const ValidityMask none = MaskOf({"......", "......", "......", "......"});
  EXPECT_TRUE(ComputeValidRegion(none, kRegionImage).empty());
  EXPECT_EQ(ThereAndBack(none), none.is_valid);
}

// mrcal draws the whole image so.
TEST(ValidRegion, FromPixelToPixelIsTheWholeImage) {
  ValidRegion region = {{0, 0}, {21, 0}, {21, 13}, {0, 13}};
  for (int k = 0; k < 2; ++k) {
    EXPECT_FALSE(MakeValidityMask(region, kRegionImage).is_valid.empty());
    for (const bool is_valid : MakeValidityMask(region, kRegionImage).is_valid)
      EXPECT_TRUE(is_valid);
    region.push_back(region.front());
  }
}

}  // namespace
}  // namespace raygrid
