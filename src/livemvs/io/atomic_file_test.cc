#include "livemvs/io/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "livemvs/core/error.h"

namespace livemvs {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class AtomicFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::path(::testing::TempDir()) /
        (std::string("atomic_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static std::string Contents(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  long FilesInFolder() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  }
  static void ExpectUnwritable(const fs::path& path, const std::string& part) {
    try {
      CheckWritable(path);
      FAIL() << path << " passed as writable";
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::kBadInput);
      EXPECT_THAT(e.what(), HasSubstr(path.string()));
      EXPECT_THAT(e.what(), HasSubstr(part));
    }
  }

  fs::path folder_;
};

TEST_F(AtomicFileTest, AppearsOnlyWhenCommitted) {
  const fs::path path = folder_ / "a.txt";
  std::string text(1'000'000, 'x');
  text += "end";
  AtomicFile file(path);
  file.Write(text);
  EXPECT_FALSE(fs::exists(path));
  file.Commit();
  EXPECT_EQ(Contents(path), text);
  EXPECT_EQ(FilesInFolder(), 1);
  EXPECT_THROW(file.Write("more"), Error);
}

TEST_F(AtomicFileTest, LeavesTheOldFileWhenAbandoned) {
  const fs::path path = folder_ / "a.txt";
  std::ofstream(path) << "old";
  {
    AtomicFile file(path);
    file.Write("new");
  }
  EXPECT_EQ(Contents(path), "old");
  EXPECT_EQ(FilesInFolder(), 1);
}

TEST_F(AtomicFileTest, SeeksBackToPatchAHeader) {
  const fs::path path = folder_ / "a.bin";
  AtomicFile file(path);
  file.Write("____ body");
  file.Seek(0);
  file.Write("head");
  EXPECT_EQ(file.position(), 4);
  file.Seek(file.size());
  file.Write("!");
  file.Commit();
  EXPECT_EQ(Contents(path), "head body!");
}

TEST_F(AtomicFileTest, KeepsASymbolicLink) {
  std::ofstream(folder_ / "real") << "old";
  fs::create_symlink(folder_ / "real", folder_ / "link");
  AtomicFile file(folder_ / "link");
  file.Write("new");
  file.Commit();
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(Contents(folder_ / "real"), "new");
}

TEST_F(AtomicFileTest, RespectsTheUmask) {
  const mode_t old_mask = ::umask(0027);
  AtomicFile file(folder_ / "a");
  ::umask(old_mask);
  file.Commit();
  EXPECT_EQ(fs::status(folder_ / "a").permissions(), fs::perms(0640));
}

TEST_F(AtomicFileTest, ReportsAFullDisk) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  AtomicFile file("/dev/full");
  try {
    file.Write("data");
    file.Commit();
    FAIL() << "wrote to a full device";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::kOutOfResource);
    EXPECT_THAT(e.what(), HasSubstr("disk full"));
    EXPECT_THAT(e.what(), HasSubstr("/dev/full"));
  }
}

TEST_F(AtomicFileTest, RemovesTheTemporaryFileWhenAWriteFails) {
  rlimit old_limit{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  std::ofstream(folder_ / "a") << "old";
  const rlimit small{1000, old_limit.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  {
    AtomicFile file(folder_ / "a");
    const std::string text(100'000, 'x');
    file.Write(text);
    EXPECT_THROW(file.Commit(), Error);
    EXPECT_EQ(FilesInFolder(), 1);
  }
  ::setrlimit(RLIMIT_FSIZE, &old_limit);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_EQ(Contents(folder_ / "a"), "old");
}

TEST_F(AtomicFileTest, CheckWritableLeavesNothingBehind) {
  CheckWritable(folder_ / "a");
  EXPECT_EQ(FilesInFolder(), 0);
  std::ofstream(folder_ / "b") << "old";
  CheckWritable(folder_ / "b");
  EXPECT_EQ(Contents(folder_ / "b"), "old");
  EXPECT_EQ(FilesInFolder(), 1);
}

TEST_F(AtomicFileTest, CheckWritableFindsWhatCannotBeWritten) {
  ExpectUnwritable(folder_, "is a directory");
  ExpectUnwritable(folder_ / "", "is a directory");
  ExpectUnwritable(folder_ / "missing" / "a", "does not exist");
  std::ofstream(folder_ / "file") << "x";
  ExpectUnwritable(folder_ / "file" / "a", "is not a directory");
  ExpectUnwritable(folder_ / std::string(300, 'n'), "cannot be written");
  EXPECT_THROW(CheckWritable(""), Error);
  if (::geteuid() == 0) return;  // Root may write anywhere.
  fs::permissions(folder_ / "file", fs::perms::owner_read);
  ExpectUnwritable(folder_ / "file", "ermission denied");
  fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
  ExpectUnwritable(folder_ / "new", "ermission denied");
  fs::permissions(folder_, fs::perms::owner_all);
}

}  // namespace
}  // namespace livemvs
