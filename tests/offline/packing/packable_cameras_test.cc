// Cameras that blobs cannot hold, or of which no table can be made as usual.

#include <algorithm>

#include "packed_cameras.h"

namespace raygrid {
namespace {

OpenCvModel Lens(const ImageSize& size, const Area& area, double focal_px,
                 const Eigen::Vector2d& center, double k1) {
  return OpenCvModel(
      size, area,
      {focal_px, focal_px, center.x(), center.y(), k1, 0, 0, 0, 0, 0, 0, 0});
}

PackedCamera PackLens(const OpenCvModel& lens) {
  CameraFile file;
  file.camera = lens.Clone();
  return PackSupportedSections(file, 2);
}

// Packs with the table that a user gets who asks for no special view.
void PackUsualView(const CameraModel& camera) {
  PackOptions options;
  options.remaps = {MakeView(camera, {})};
  CameraFile file;
  file.camera = camera.Clone();
  PackCamera(file, options);
}

void ExpectRemark(const std::string& words, const PackedCamera& packed) {
  ASSERT_EQ(packed.warnings.size(), 1u)
      << testing::PrintToString(packed.warnings);
  EXPECT_NE(packed.warnings[0].find(words), std::string::npos)
      << packed.warnings[0];
}

TEST(PackSupportedSections, IsThatOfPackWhereAllCanBe) {
  EXPECT_EQ(PackSupportedSections(GenericFile(), 2).blob, Packed().blob);
}

// The area is seen 60 degrees and more off the axis.
TEST(PackSupportedSections, ShowsTheAreaWhereTheUsualViewShowsNothingOfIt) {
  const OpenCvModel lens =
      Lens({640, 480}, {375, 140, 475, 340}, 60, {200, 240}, 0.05);
  ExpectError(ExitCode::kUsage, {"does not overlap"},
              [&] { PackUsualView(lens); });
  const PackedCamera packed = PackLens(lens);
  ExpectRemark("limited to the calibrated area", packed);
  ASSERT_EQ(packed.remaps.size(), 1u);
  EXPECT_LE(packed.remaps[0].error_px, 0.05);
  EXPECT_EQ(packed.remaps[0].view.size.width, 640);
  // Some of it is to be seen.
  Image white;
  white.size = {640, 480};
  white.channels = 1;
  white.pixels.assign(640 * 480, 255);
  const Image flat = BlobCamera("packed", packed.blob).Undistort(white, 0);
  EXPECT_GT(std::count(flat.pixels.begin(), flat.pixels.end(), 255), 640 * 48);
}

TEST(PackSupportedSections, ShowsTheAreaWhereTheUsualTableIsNotExact) {
  const OpenCvModel lens =
      Lens({640, 480}, {142.2337, 140, 342.2337, 340}, 60, {168, 236}, 0.26);
  ExpectError(ExitCode::kQualityTooLow, {"remap error"},
              [&] { PackUsualView(lens); });
  const PackedCamera packed = PackLens(lens);
  EXPECT_FALSE(packed.blob.empty());
  ASSERT_EQ(packed.warnings.size(), 1u);
}

TEST(PackSupportedSections, LeavesOutTablesOfImagesThatAreTooLarge) {
  const ImageSize size = {9000, 60};
  const PackedCamera packed =
      PackLens(Lens(size, WholeImage(size), 9000, {4499, 29}, -0.05));
  ExpectRemark("no undistortion table", packed);
  EXPECT_FALSE(packed.blob.empty());
  EXPECT_TRUE(packed.remaps.empty());
}

TEST(PackSupportedSections, LeavesOutBlobsOfImagesThatAreTooLarge) {
  const ImageSize size = {20000, 15000};
  const PackedCamera packed =
      PackLens(Lens(size, WholeImage(size), 15000, {9999, 7499}, -0.05));
  ExpectRemark("is omitted", packed);
  EXPECT_TRUE(packed.blob.empty());
}

}  // namespace
}  // namespace raygrid
