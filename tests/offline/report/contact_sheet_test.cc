#include "report/contact_sheet.h"

#include "support.h"

namespace raygrid {
namespace {

SheetTile GreyTile(const ImageSize& size) {
  SheetTile tile;
  tile.title = "a";
  tile.caption = {"b"};
  tile.picture.size = size;
  tile.picture.pixels.assign(static_cast<size_t>(size.width) * size.height, 90);
  return tile;
}

const uint8_t* SheetPixel(const Image& sheet, int x, int y) {
  return &sheet.pixels[y * sheet.stride() + 3 * x];
}

// The first and the last column and row of pixels for which is_meant(pixel).
template <typename IsMeant>
Area BoxOf(const Image& sheet, const IsMeant& is_meant) {
  Area box = {1e9, 1e9, -1, -1};
  for (int y = 0; y < sheet.size.height; ++y)
    for (int x = 0; x < sheet.size.width; ++x)
      if (is_meant(SheetPixel(sheet, x, y)))
        box = {std::min<double>(box.x0, x), std::min<double>(box.y0, y),
               std::max<double>(box.x1, x), std::max<double>(box.y1, y)};
  return box;
}

Area BoxOfGrey(const Image& sheet) {
  return BoxOf(sheet, [](const uint8_t* pixel) {
    return pixel[0] == 90 && pixel[1] == 90 && pixel[2] == 90;
  });
}

TEST(ContactSheet, IsAtMost2400PixelsWide) {
  for (const size_t num_tiles : {1, 2, 3, 4, 5, 9}) {
    const SheetRow row = {
        std::vector<SheetTile>(num_tiles, GreyTile({64, 48}))};
    const Image sheet = ContactSheet({row}, {});
    EXPECT_LE(sheet.size.width, 2400);
    EXPECT_EQ(sheet.channels, 3);
    // Four tiles stand beside each other, then comes another line.
    const Image less = ContactSheet({{{GreyTile({64, 48})}}}, {});
    if (num_tiles > 4) {
      EXPECT_GT(sheet.size.height, less.size.height);
    }
  }
}

TEST(ContactSheet, KeepsTheShapeOfPictures) {
  const Area wide = BoxOfGrey(ContactSheet({{{GreyTile({80, 40})}}}, {}));
  EXPECT_NEAR((wide.width() + 1) / (wide.height() + 1), 2, 0.01);
  const Area tall = BoxOfGrey(ContactSheet({{{GreyTile({30, 90})}}}, {}));
  EXPECT_NEAR((tall.height() + 1) / (tall.width() + 1), 3, 0.02);
}

TEST(ContactSheet, DrawsCurvesWhereTheirPixelsAre) {
  SheetTile tile = GreyTile({100, 50});
  SheetCurves curves;
  curves.color = {1, 0, 0};
  curves.curves = {{{24.5, 9.5}, {24.5, 39.5}}};
  tile.curves = {curves};
  const Image sheet = ContactSheet({{{tile}}}, {});
  const Area picture = BoxOfGrey(sheet);
  const Area red = BoxOf(sheet, [](const uint8_t* pixel) {
    return pixel[2] > 250 && pixel[0] < 10;
  });
  // A quarter of the width.
  EXPECT_NEAR(red.center().x(), picture.x0 + (picture.width() + 1) / 4, 1);
  EXPECT_NEAR(red.center().y(), picture.center().y() + 0.5, 1.5);
  EXPECT_NEAR(red.height(), (picture.height() + 1) * 30 / 50, 4);
}

TEST(ContactSheet, TextStaysInItsColumn) {
  SheetTile tile = GreyTile({64, 48});
  tile.title = std::string(500, 'W');
  tile.caption = {std::string(500, 'W'), "°°°°"};
  const Image sheet = ContactSheet({{{tile}}}, {});
  for (int y = 0; y < sheet.size.height; ++y)
    for (int x = sheet.size.width - 20; x < sheet.size.width; ++x)
      ASSERT_EQ(SheetPixel(sheet, x, y)[0], 255) << x << ", " << y;
}

TEST(ContactSheet, SaysWhatStandsInThePlaceOfAPicture) {
  SheetTile tile;
  tile.message = "No view: the camera sees nothing there";
  const Image sheet = ContactSheet({{{tile}}}, {});
  tile.message = "";
  EXPECT_NE(ContactSheet({{{tile}}}, {}).pixels, sheet.pixels);
}

TEST(ContactSheet, RefusesMoreThanAPictureHolds) {
  const std::vector<SheetRow> rows(100, SheetRow{{GreyTile({64, 64})}});
  ExpectError(ExitCode::kUsage, {"fewer"}, [&] { ContactSheet(rows, {}); });
}

}  // namespace
}  // namespace raygrid
