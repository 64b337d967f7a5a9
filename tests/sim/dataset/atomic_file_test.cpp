#include "sim/dataset/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <stdexcept>

#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

std::size_t files_in(const fs::path& folder) {
  std::size_t count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    count += entry.is_regular_file() ? 1 : 0;
  return count;
}

TEST(AtomicFile, WritesAllBytesAndMakesFolders) {
  const TemporaryFolder folder;
  const std::string bytes = std::string("a\0b\n", 4) + std::string(100'000, 'x');
  write_file(folder.path() / "new" / "folder" / "file.bin", bytes);
  EXPECT_EQ(read_file(folder.path() / "new/folder/file.bin"), bytes);
  write_file(folder.path() / "new/folder/file.bin", "short");
  EXPECT_EQ(read_file(folder.path() / "new/folder/file.bin"), "short");
  EXPECT_EQ(files_in(folder.path()), 1U);  // nothing beside it
}

TEST(AtomicFile, ReadingNamesWhatIsWrong) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { read_file(folder.path() / "absent"); }), testing::HasSubstr("absent"));
  EXPECT_THAT(error_of([&] { read_file(folder.path()); }),
              testing::HasSubstr("not a regular file"));
  write_file(folder.path() / "long", "12345");
  EXPECT_THAT(error_of([&] { read_file(folder.path() / "long", 4); }),
              testing::HasSubstr("the limit is 4"));
  ASSERT_EQ(mkfifo((folder.path() / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(error_of([&] { read_file(folder.path() / "pipe"); }),
              testing::HasSubstr("not a regular file"));
}

/// Writes more than the disk holds over a finished file; the file must stay and nothing be left
/// beside it.
void expect_old_file_survives(const fs::path& folder) {
  const std::string big(std::size_t{1} << 20, 'x');
  EXPECT_THAT(error_of([&] { write_file(folder / "result.json", big); }),
              testing::HasSubstr("result.json: cannot write"));
  EXPECT_EQ(read_file(folder / "result.json"), "finished");
  EXPECT_EQ(files_in(folder), 1U);
}

TEST(AtomicFile, FullDiskKeepsTheFinishedFile) {
  const TemporaryFolder folder;
  if (mount("tmpfs", folder.path().c_str(), "tmpfs", 0, "size=64k") != 0)
    GTEST_SKIP() << "this user may not mount a tmpfs";
  write_file(folder.path() / "result.json", "finished");
  expect_old_file_survives(folder.path());
  umount(folder.path().c_str());
}

TEST(AtomicFile, FileSizeLimitKeepsTheFinishedFile) {
  const TemporaryFolder folder;
  write_file(folder.path() / "result.json", "finished");
  std::signal(SIGXFSZ, SIG_IGN);  // so that write() returns the error
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit small = before;
  small.rlim_cur = 1 << 16;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  expect_old_file_survives(folder.path());
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_DFL);
}

TEST(AtomicFile, ReadOnlyFolderKeepsTheFinishedFile) {
  const TemporaryFolder folder;
  write_file(folder.path() / "result.json", "finished");
  fs::permissions(folder.path(), fs::perms::owner_read | fs::perms::owner_exec |
                                     fs::perms::others_read | fs::perms::others_exec);
  const bool is_root =
      geteuid() == 0;  // root may write anywhere: become somebody else for a moment
  if (is_root) {
    ASSERT_EQ(seteuid(65534), 0);
  }
  const std::string error = error_of([&] { write_file(folder.path() / "result.json", "new"); });
  const std::string below =
      error_of([&] { write_file(folder.path() / "sub" / "result.json", "new"); });
  if (is_root) {
    ASSERT_EQ(seteuid(0), 0);
  }
  fs::permissions(folder.path(), fs::perms::owner_all);
  EXPECT_THAT(error, testing::HasSubstr("result.json: cannot write: Permission denied"));
  EXPECT_THAT(below, testing::HasSubstr("sub: cannot make the folder: Permission denied"));
  EXPECT_EQ(read_file(folder.path() / "result.json"), "finished");
}

TEST(ResolveInside, RefusesEveryWayOut) {
  const TemporaryFolder folder, other;
  fs::create_directories(folder.path() / "images");
  fs::create_directory_symlink(other.path(), folder.path() / "link");
  fs::create_symlink("/etc/passwd", folder.path() / "images" / "0.png");
  fs::create_symlink("images", folder.path() / "inner");
  const auto error = [&](const fs::path& path) {
    return error_of([&] { resolve_inside(folder.path(), path); });
  };
  EXPECT_EQ(error("images/absent.png"), "");
  EXPECT_EQ(error("inner/absent.png"), "");
  EXPECT_THAT(error("../x"), testing::HasSubstr("\"..\""));
  EXPECT_THAT(error("images/../../x"), testing::HasSubstr("\"..\""));
  EXPECT_THAT(error("/etc/passwd"), testing::HasSubstr("absolute"));
  EXPECT_THAT(error("link/x"), testing::HasSubstr("symbolic link"));
  EXPECT_THAT(error("images/0.png"), testing::HasSubstr("symbolic link"));
  EXPECT_THAT(error(std::string("a\0b", 3)), testing::HasSubstr("zero byte"));
  EXPECT_THAT(error(""), testing::HasSubstr("empty"));
}

}  // namespace
}  // namespace cousin
