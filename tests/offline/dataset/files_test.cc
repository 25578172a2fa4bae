#include "dataset/files.h"

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <thread>

#include "dataset/image_files.h"
#include "dataset/parallel_for.h"
#include "support.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

TEST(Files, ReadFileInvertsWriteFile) {
  const TemporaryFolder folder;
  std::string bytes;
  for (unsigned i = 0; i < 100000; ++i) bytes += static_cast<char>(i * i % 256);
  WriteFile(folder / "new/deep/file", bytes);
  EXPECT_EQ(ReadFile(folder / "new/deep/file"), bytes);
  WriteFile(folder / "new/deep/file", "");
  EXPECT_EQ(ReadFile(folder / "new/deep/file"), "");
}

TEST(Files, UnreadableFilesAreNamed) {
  const TemporaryFolder folder;
  ExpectError(ExitCode::kInvalidInput, {"missing.csv"},
              [&] { ReadFile(folder / "missing.csv"); });
  fs::create_directory(folder / "dir.csv");
  ExpectError(ExitCode::kInvalidInput, {"dir.csv"},
              [&] { ReadFile(folder / "dir.csv"); });
}

TEST(OutputFiles, WritesAllOfThemAndNothingElse) {
  const TemporaryFolder folder;
  OutputFiles files;
  files.Add(folder / "a", "1");
  files.Add(folder / "b", "2");
  EXPECT_EQ(folder.Count(), 0);
  files.Commit();
  EXPECT_EQ(folder.Count(), 2);
  EXPECT_EQ(ReadFile(folder / "a"), "1");
  EXPECT_EQ(ReadFile(folder / "b"), "2");
}

// One target cannot be made: the others keep what they had.
void ExpectNothingWritten(const std::string& good, const std::string& bad,
                          const TemporaryFolder& folder) {
  WriteFile(folder / "regular", "a file where a folder is expected");
  fs::create_directory(folder / "directory");
  const int count = folder.Count();
  OutputFiles files;
  files.Add(folder / good, "new");
  files.Add(folder / bad, "new");
  files.Add(folder / "last", "new");
  ExpectError(ExitCode::kOutputFailed, {folder / bad.substr(0, bad.find('/'))},
              [&] { files.Commit(); });
  EXPECT_EQ(folder.Count(), count);
  EXPECT_TRUE(fs::is_empty(folder / "directory"));
}

TEST(OutputFiles, WritesNothingIfAFolderCannotBeMade) {
  const TemporaryFolder folder;
  ExpectNothingWritten("a", "regular/b", folder);
  EXPECT_FALSE(fs::exists(folder / "a"));
}

TEST(OutputFiles, WritesNothingIfATargetIsAFolder) {
  const TemporaryFolder folder;
  ExpectNothingWritten("a", "directory", folder);
  EXPECT_FALSE(fs::exists(folder / "a"));
}

TEST(OutputFiles, FailureLeavesOlderFilesAsTheyWere) {
  for (const char* bad : {"regular/b", "directory"}) {
    const TemporaryFolder folder;
    WriteFile(folder / "a", "old");
    ExpectNothingWritten("a", bad, folder);
    EXPECT_EQ(ReadFile(folder / "a"), "old");
  }
}

TEST(OutputFiles, LinksAndPipesStayWhatTheyAre) {
  const TemporaryFolder folder;
  const std::string pipe = folder / "pipe";
  WriteFile(folder / "file", "old");
  fs::create_symlink("file", folder / "link");
  WriteFile(folder / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(ReadFile(folder / "file"), "new");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::string read;
  std::thread reader([&] { read = ReadFile(pipe); });
  WriteFile(pipe, "through");
  reader.join();
  EXPECT_EQ(read, "through");
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST(OutputFiles, ReplacesLinksThatAreNotTheUsers) {
  const TemporaryFolder folder;
  WriteFile(folder / "file", "mine");
  fs::create_directory(folder / "directory");
  for (const char* target : {"file", "directory", "/dev/null", "nowhere"}) {
    fs::create_symlink(target, folder / "link");
    OutputFiles files;
    files.Add(folder / "link", "new", Links::kReplace);
    files.Commit();
    EXPECT_FALSE(fs::is_symlink(folder / "link")) << target;
    EXPECT_EQ(ReadFile(folder / "link"), "new") << target;
    fs::remove(folder / "link");
  }
  EXPECT_EQ(ReadFile(folder / "file"), "mine");
  EXPECT_EQ(folder.Count(), 2);
}

TEST(OutputFiles, WriteThroughNoLinkThatStandsWhereTheyAreMade) {
  const TemporaryFolder folder;
  WriteFile(folder / "mine", "mine");
  fs::create_symlink("mine",
                     folder / ("file.part-" + std::to_string(getpid())));
  WriteFile(folder / "file", "new");
  EXPECT_EQ(ReadFile(folder / "file"), "new");
  EXPECT_EQ(ReadFile(folder / "mine"), "mine");
}

TEST(RequireNoInputReplaced, KnowsAFileUnderAnyName) {
  const TemporaryFolder folder;
  WriteFile(folder / "a", "1");
  WriteFile(folder / "b", "2");
  fs::create_symlink("a", folder / "link");
  fs::create_hard_link(folder / "a", folder / "twin");
  const std::vector<std::string> inputs = {folder / "b", folder / "a", ""};
  for (const char* name : {"a", "./b", "link", "twin"})
    ExpectError(ExitCode::kOutputFailed, {name, "would overwrite"},
                [&] { RequireNoInputReplaced(inputs, {folder / name}); });
  RequireNoInputReplaced(inputs, {folder / "c", ""});
  RequireNoInputReplaced({"/dev/null"}, {"/dev/null"});
}

TEST(ReadFile, DevicesAreRefused) {
  for (const char* device : {"/dev/zero", "/dev/null"})
    ExpectError(ExitCode::kInvalidInput, {device}, [&] { ReadFile(device); });
}

TEST(RequireWritableFolder, MakesTheFolderAndLeavesItEmpty) {
  const TemporaryFolder folder;
  RequireWritableFolder(folder / "new/results");
  EXPECT_TRUE(fs::is_directory(folder / "new/results"));
  EXPECT_TRUE(fs::is_empty(folder / "new/results"));
  WriteFile(folder / "regular", "");
  ExpectError(ExitCode::kOutputFailed, {"regular"},
              [&] { RequireWritableFolder(folder / "regular/x"); });
}

Image Gradient() {
  Image image;
  image.size = {37, 23};
  for (int i = 0; i < 37 * 23; ++i)
    image.pixels.push_back(static_cast<uint8_t>(i * 7));
  return image;
}

TEST(ImageFiles, ReadImageInvertsEncodePng) {
  const TemporaryFolder folder;
  WriteFile(folder / "grey.png", EncodePng(Gradient()));
  const Image grey = ReadImage(folder / "grey.png", true);
  EXPECT_EQ(grey.size, Gradient().size);
  EXPECT_EQ(grey.channels, 1);
  EXPECT_EQ(grey.pixels, Gradient().pixels);
  const Image color = ReadImage(folder / "grey.png", false);
  EXPECT_EQ(color.channels, 3);
  EXPECT_EQ(color.pixels.size(), 3 * grey.pixels.size());
}

TEST(ImageFiles, DamagedImagesAreNamed) {
  const TemporaryFolder folder;
  WriteFile(folder / "empty.png", "");
  WriteFile(folder / "text.png", "no image");
  for (const char* name : {"empty.png", "text.png"})
    ExpectError(ExitCode::kInvalidInput, {name},
                [&] { ReadImage(folder / name, true); });
}

TEST(ImageFiles, FoldersGiveTheirImagesInOrder) {
  const TemporaryFolder folder;
  for (const char* name : {"b.PNG", "a.jpg", "notes.txt", "c.tiff"})
    WriteFile(folder / "in" + std::string("/") + name, "");
  const auto found = FindImages({folder / "in", "other.png"}).paths;
  ASSERT_EQ(found.size(), 4u);
  EXPECT_EQ(fs::path(found[0]).filename(), "a.jpg");
  EXPECT_EQ(fs::path(found[1]).filename(), "b.PNG");
  EXPECT_EQ(fs::path(found[2]).filename(), "c.tiff");
  EXPECT_EQ(found[3], "other.png");
}

TEST(ImageFiles, OrderIsThatOfTheirNamesWhateverWasGivenFirst) {
  const TemporaryFolder folder;
  for (const char* name : {"x/b.png", "x/d.png", "y/a.png", "y/c.png"})
    WriteFile(folder / name, "");
  const std::vector<std::string> expected = {
      folder / "y/a.png", folder / "x/b.png", folder / "y/c.png",
      folder / "x/d.png"};
  EXPECT_EQ(FindImages({folder / "x", folder / "y"}).paths, expected);
  EXPECT_EQ(FindImages({folder / "y", folder / "x"}).paths, expected);
  EXPECT_EQ(FindImages({folder / "x/d.png", folder / "y/c.png",
                        folder / "x/b.png", folder / "y/a.png"})
                .paths,
            expected);
}

TEST(ImageFiles, PicturesOfRaygridAndUnknownKindsAreLeftOutOfFolders) {
  const TemporaryFolder folder;
  for (const char* name : {"a.png", "coverage.png", "example_after.png",
                           "example_before.png", "uncertainty.png", "b.HEIC"})
    WriteFile(folder / "in" + std::string("/") + name, "");
  const FoundImages found =
      FindImages({folder / "in", folder / "in/coverage.png"});
  EXPECT_EQ(found.paths, (std::vector<std::string>{
                             folder / "in/a.png", folder / "in/coverage.png"}));
  ASSERT_EQ(found.left_out.size(), 5u);
  EXPECT_EQ(found.left_out[0].path, folder / "in/b.HEIC");
  EXPECT_NE(found.left_out[0].reason.find("convert"), std::string::npos);
  EXPECT_NE(found.left_out[1].reason.find("raygrid"), std::string::npos);
}

TEST(ImageFiles, FoldersWithoutImagesAreRefused) {
  const TemporaryFolder folder;
  WriteFile(folder / "in/notes.txt", "");
  ExpectError(ExitCode::kInvalidInput, {"no images"},
              [&] { FindImages({folder / "in"}); });
}

TEST(ParallelFor, CallsTheBodyOnceForEachIndex) {
  for (const int num_threads : {0, 1, 2, 9}) {
    std::vector<int> calls(1000, 0);
    ParallelFor(1000, num_threads, [&](int i) { ++calls[i]; });
    EXPECT_EQ(calls, std::vector<int>(1000, 1));
  }
  ParallelFor(0, 4, [](int) { FAIL(); });
}

TEST(ParallelFor, RethrowsWhatABodyThrows) {
  for (const int num_threads : {1, 3})
    ExpectError(ExitCode::kInvalidInput, {"seven"}, [&] {
      ParallelFor(100, num_threads, [](int i) {
        if (i == 7) throw InputError("seven");
      });
    });
}

}  // namespace
}  // namespace raygrid
