#include "features/detection_cache.h"

#include <cstdlib>

#include "dataset/files.h"
#include "features/pattern_detector.h"
#include "support.h"

namespace raygrid {
namespace {

DetectedImage ExampleSeenImage() {
  DetectedImage seen;
  seen.size = {640, 480};
  seen.detection.features = {{0, 1, 2, {1.0 / 3, 2e-9}},
                             {4, -1, 0, {479.1, -0.25}}};
  seen.detection.rejected = {{{0, 5, 6, {7.1, 8.3}}, "moved by 3.1 px"}};
  seen.detection.warnings = {"board 0 is mirrored", "tag 7"};
  return seen;
}

void ExpectSame(const Feature& a, const Feature& b) {
  EXPECT_EQ(a.board, b.board);
  EXPECT_EQ(a.column, b.column);
  EXPECT_EQ(a.row, b.row);
  EXPECT_EQ(a.pixel, b.pixel);
}

void ExpectSame(const DetectedImage& a, const DetectedImage& b) {
  EXPECT_EQ(a.size, b.size);
  ASSERT_EQ(a.detection.features.size(), b.detection.features.size());
  for (size_t i = 0; i < a.detection.features.size(); ++i)
    ExpectSame(a.detection.features[i], b.detection.features[i]);
  ASSERT_EQ(a.detection.rejected.size(), b.detection.rejected.size());
  for (size_t i = 0; i < a.detection.rejected.size(); ++i) {
    ExpectSame(a.detection.rejected[i].feature,
               b.detection.rejected[i].feature);
    EXPECT_EQ(a.detection.rejected[i].reason, b.detection.rejected[i].reason);
  }
  EXPECT_EQ(a.detection.warnings, b.detection.warnings);
}

TEST(DetectionCache, GivesBackWhatWasStoredToTheLastBit) {
  const TemporaryFolder folder;
  const DetectionCache cache(folder / "new/cache");
  EXPECT_FALSE(cache.Find("key"));
  cache.Store("key", ExampleSeenImage());
  const auto found = cache.Find("key");
  ASSERT_TRUE(found);
  ExpectSame(*found, ExampleSeenImage());
  EXPECT_FALSE(cache.Find("other"));
}

TEST(DetectionCache, KeyDependsOnEverythingThatDetectionDoes) {
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  const std::string key = DetectionCache::Key("bytes", pattern, {});
  EXPECT_EQ(key.size(), 32u);
  EXPECT_EQ(key, DetectionCache::Key("bytes", pattern, {}));
  EXPECT_NE(key, DetectionCache::Key("byte", pattern, {}));
  EXPECT_NE(key,
            DetectionCache::Key("bytes", ChessboardPattern(9, 7, 0.025), {}));
  EXPECT_NE(key, DetectionCache::Key("bytes", pattern,
                                     {Refinement::kIntensities, 23}));
  EXPECT_NE(key,
            DetectionCache::Key("bytes", pattern, {Refinement::kNone, 21}));
}

TEST(DetectionCache, DamagedFilesAreNotBelieved) {
  const TemporaryFolder folder;
  const DetectionCache cache(folder / ".");
  cache.Store("key", ExampleSeenImage());
  const std::string path = folder / "key.detection";
  const std::string good = ReadFile(path);
  for (size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] ^= 1;
    WriteFile(path, bad);
    EXPECT_FALSE(cache.Find("key")) << i;
    WriteFile(path, good.substr(0, i));
    EXPECT_FALSE(cache.Find("key")) << i;
  }
  WriteFile(folder / "other.detection", good);
  EXPECT_FALSE(cache.Find("other"));
  cache.Store("key", ExampleSeenImage());
  EXPECT_TRUE(cache.Find("key"));
}

TEST(DetectionCache, FolderThatCannotBeMadeIsNoError) {
  const TemporaryFolder folder;
  WriteFile(folder / "file", "in the way");
  for (const std::string& place : {folder / "file/cache", std::string()}) {
    const DetectionCache cache(place);
    cache.Store("key", ExampleSeenImage());
    EXPECT_FALSE(cache.Find("key"));
    cache.Trim();
  }
}

TEST(DetectionCache, OldestFilesGoFirstAndOthersStay) {
  const TemporaryFolder folder;
  const DetectionCache cache(folder / ".");
  WriteFile(folder / "letter.txt", "not ours");
  const auto now = std::filesystem::file_time_type::clock::now();
  for (int i = 0; i < 5; ++i) {
    cache.Store(std::to_string(i), ExampleSeenImage());
    std::filesystem::last_write_time(
        folder / (std::to_string(i) + ".detection"),
        now - std::chrono::seconds(i));
  }
  cache.Trim(3);
  EXPECT_EQ(folder.Count(), 4);
  EXPECT_TRUE(cache.Find("0"));
  EXPECT_FALSE(cache.Find("3"));
  EXPECT_FALSE(cache.Find("4"));
}

TEST(DetectionCache, DefaultFolderFollowsTheEnvironment) {
  const char* home = std::getenv("HOME");
  const std::string old_home = home ? home : "";
  const char* xdg = std::getenv("XDG_CACHE_HOME");
  const std::string old_xdg = xdg ? xdg : "";
  setenv("HOME", "/home/someone", 1);
  setenv("XDG_CACHE_HOME", "/var/caches", 1);
  EXPECT_EQ(DetectionCache::DefaultFolder(), "/var/caches/raygrid");
  setenv("XDG_CACHE_HOME", "relative", 1);
  EXPECT_EQ(DetectionCache::DefaultFolder(), "/home/someone/.cache/raygrid");
  unsetenv("XDG_CACHE_HOME");
  unsetenv("HOME");
  EXPECT_EQ(DetectionCache::DefaultFolder(), "");
  if (home) setenv("HOME", old_home.c_str(), 1);
  if (xdg) setenv("XDG_CACHE_HOME", old_xdg.c_str(), 1);
}

TEST(DetectionCache, DetectionTakesWhatItHoldsAndRepairsIt) {
  const TemporaryFolder folder;
  const DetectionCache cache(folder / "cache");
  const Pattern pattern = ChessboardPattern(9, 6, 0.025);
  Image image;
  image.size = {40, 40};
  image.pixels.assign(1600, 100);
  const std::string bytes = EncodePng(image);
  WriteFile(folder / "a.png", bytes);
  DetectedImage planted = ExampleSeenImage();
  planted.size = image.size;
  cache.Store(DetectionCache::Key(bytes, pattern, {}), planted);
  const auto detect = [&] {
    return DetectFeatures({folder / "a.png"}, pattern, {}, &cache, 1, nullptr);
  };
  EXPECT_EQ(detect().dataset.num_features(), 2u);
  const std::string path =
      folder /
      ("cache/" + DetectionCache::Key(bytes, pattern, {}) + ".detection");
  WriteFile(path, "damaged");
  EXPECT_EQ(detect().dataset.num_features(), 0u);
  EXPECT_NE(ReadFile(path), "damaged");
}

}  // namespace
}  // namespace raygrid
