#include "dataset/output_folder.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/ptrace.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <map>

#include "dataset/files.h"
#include "support.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

// Files by their paths, hidden ones too.
using Files = std::map<std::string, std::string>;

Files FilesIn(const std::string& folder) {
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      files[entry.path().lexically_relative(folder).string()] =
          ReadFile(entry.path().string());
  return files;
}

void WriteTo(const std::string& folder, const Files& files) {
  for (const auto& [path, contents] : files)
    WriteFile(folder + "/" + path, contents);
}

const std::set<std::string> kStale = {"a", "b", "old", "cam0/a", "cam1/a"};
const Files kOld = {
    {"a", "old"}, {"old", "old"}, {"cam0/a", "old"}, {"cam1/a", "old"}};
const Files kOthers = {{"mine.txt", "mine"}, {"cam0/mine", "mine"}};
const Files kNew = {{"a", "new"}, {"b", "new"}, {"cam0/a", "new"}};

Files Joined(Files a, const Files& b) {
  a.insert(b.begin(), b.end());
  return a;
}

void Replace(const std::string& folder) {
  OutputFolder output(folder);
  WriteTo(output.path(), kNew);
  output.Commit(kStale);
}

TEST(OutputFolder, ReplacesOldFilesAndLeavesThoseOfOthers) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  WriteTo(out, Joined(kOld, kOthers));
  fs::permissions(out, fs::perms(0751));
  Replace(out);
  EXPECT_EQ(FilesIn(folder / ""), [] {
    Files expected;
    for (const auto& [path, text] : Joined(kNew, kOthers))
      expected["out/" + path] = text;
    return expected;
  }());
  EXPECT_FALSE(fs::exists(out + "/cam1"));
  EXPECT_EQ(fs::status(out).permissions(), fs::perms(0751));
}

TEST(OutputFolder, IsThereAsSoonAsItIsAskedFor) {
  const TemporaryFolder folder;
  Replace(folder / "new/out");
  EXPECT_EQ(FilesIn(folder / "new/out"), kNew);
  EXPECT_EQ(FilesIn(folder / "new").size(), kNew.size());
}

TEST(OutputFolder, IsAsItWasWithoutCommit) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  WriteTo(out, Joined(kOld, kOthers));
  const Files before = FilesIn(folder / "");
  {
    OutputFolder output(out);
    WriteTo(output.path(), kNew);
  }
  EXPECT_EQ(FilesIn(folder / ""), before);
  // Nor with one that cannot be.
  fs::create_directory(out + "/b");
  ExpectError(ExitCode::kOutputFailed, {"/b"}, [&] { Replace(out); });
  EXPECT_EQ(FilesIn(folder / ""), before);
}

TEST(OutputFolder, StaysInPlaceWhereOthersHaveFolders) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  const Files others = Joined(kOthers, {{"photos/1.png", "mine"}});
  WriteTo(out, Joined(kOld, others));
  const int file = open(out.c_str(), O_RDONLY);
  struct stat before, after;
  ASSERT_EQ(fstat(file, &before), 0);
  close(file);
  Replace(out);
  ASSERT_EQ(stat(out.c_str(), &after), 0);
  EXPECT_EQ(before.st_ino, after.st_ino);
  EXPECT_EQ(FilesIn(out), Joined(kNew, others));
  EXPECT_EQ(FilesIn(folder / "").size(), FilesIn(out).size());
}

TEST(OutputFolder, StaysInPlaceWhereSomebodyWorksInIt) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  WriteTo(out, kOld);
  const fs::path here = fs::current_path();
  fs::current_path(out);
  Replace(".");
  EXPECT_TRUE(fs::exists("a"));
  fs::current_path(here);
  EXPECT_EQ(FilesIn(out), kNew);
}

TEST(OutputFolder, FollowsNoLinkWithinIt) {
  for (const bool has_folder : {false, true}) {
    const TemporaryFolder folder;
    const std::string out = folder / "out";
    WriteTo(folder / "elsewhere", {{"a", "mine"}, {"cam0/a", "mine"}});
    fs::create_directory(out);
    fs::create_symlink("../elsewhere/a", out + "/a");
    fs::create_symlink("../elsewhere/cam0", out + "/cam0");
    fs::create_symlink("../elsewhere", out + "/mine");
    if (has_folder) fs::create_directory(out + "/photos");
    Replace(out);
    EXPECT_EQ(FilesIn(folder / "elsewhere"),
              (Files{{"a", "mine"}, {"cam0/a", "mine"}}));
    EXPECT_EQ(ReadFile(out + "/a"), "new");
    EXPECT_FALSE(fs::is_symlink(out + "/a"));
    EXPECT_FALSE(fs::is_symlink(out + "/cam0"));
    EXPECT_TRUE(fs::is_symlink(out + "/mine"));
  }
}

// Runs a function in a process of its own that is killed before its nth call of
// the kernel; true if it came to its end first.
bool RunUntilCall(int n, const std::function<void()>& function) {
  const pid_t child = fork();
  if (child == 0) {
    if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(99);
    raise(SIGSTOP);
    function();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFEXITED(status)) {
    ADD_FAILURE() << "ptrace is not allowed";
    return true;
  }
  for (int stop = 0;; ++stop) {
    // Each call stops twice, at its start and at its end.
    if (stop == 2 * n) {
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
      return false;
    }
    ptrace(PTRACE_SYSCALL, child, nullptr, nullptr);
    waitpid(child, &status, 0);
    if (!WIFSTOPPED(status)) return true;
  }
}

bool IsTracingAllowed() {
  const pid_t child = fork();
  if (child == 0)
    _exit(ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) == 0 ? 0 : 1);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST(OutputFolder, KillsLeaveTheOldFilesOrTheNewOnes) {
  if (!IsTracingAllowed())
    GTEST_SKIP() << "ptrace is not permitted here, as in some containers, so "
                    "no call can be interrupted";
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  const Files before = Joined(kOld, kOthers), after = Joined(kNew, kOthers);
  int num_old = 0, num_new = 0;
  for (int n = 1;; ++n) {
    fs::remove_all(out);
    WriteTo(out, before);
    const bool is_done = RunUntilCall(n, [&] { Replace(out); });
    const Files left = FilesIn(out);
    EXPECT_TRUE(left == before || left == after) << "call " << n;
    ++(left == before ? num_old : num_new);
    if (is_done) break;
  }
  EXPECT_GT(num_old, 50);
  EXPECT_GT(num_new, 5);
  // Hidden folders of killed writers go with the next folder that is written.
  Replace(out);
  EXPECT_EQ(FilesIn(folder / "").size(), after.size());
}

TEST(OutputFolder, KillsNeverMixOldAndNewFilesWhereItStaysInPlace) {
  if (!IsTracingAllowed())
    GTEST_SKIP() << "ptrace is not permitted here, as in some containers, so "
                    "no call can be interrupted";
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  const Files others = Joined(kOthers, {{"photos/1.png", "mine"}});
  for (int n = 1;; ++n) {
    fs::remove_all(out);
    WriteTo(out, Joined(kOld, others));
    const bool is_done = RunUntilCall(n, [&] { Replace(out); });
    std::set<std::string> contents;
    for (const char* name : {"a", "b", "old", "cam0/a", "cam1/a"})
      if (fs::exists(out + "/" + name))
        contents.insert(ReadFile(out + "/" + name));
    EXPECT_LE(contents.size(), 1u) << "call " << n;
    for (const auto& [path, text] : others)
      EXPECT_EQ(ReadFile(out + "/" + path), text) << "call " << n;
    if (is_done) break;
  }
  Replace(out);
  EXPECT_EQ(FilesIn(folder / "").size(), kNew.size() + others.size());
}

}  // namespace
}  // namespace raygrid
