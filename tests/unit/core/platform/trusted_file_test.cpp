#include "core/platform/trusted_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "tests/support/temporary_directory.h"

namespace sft::core {
namespace {

class TrustedFileTest : public ::testing::Test {
 protected:
  void make_file() const { std::ofstream(path_) << "words"; }
  /// Makes a file of the given owner. Returns false if this account cannot give files to other accounts.
  bool make_file_of(uid_t user, gid_t group) const {
    make_file();
    return chown(path_.c_str(), user, group) == 0 && chmod(path_.c_str(), 0666) == 0;
  }
  Error refusal(int access = O_RDONLY, const TrustedAccounts& accounts = {}) const {
    const auto file = open_trusted_file(path_, access, accounts);
    return file ? Error{Errc::system, "it was opened"} : file.error();
  }
  bool refuses(const std::string& what, int access = O_RDONLY) const {
    const Error error = refusal(access);
    EXPECT_EQ(error.code, Errc::address_in_use) << error.message;
    EXPECT_EQ(error.message.find(path_), 0U) << error.message;
    EXPECT_NE(error.message.find("remove it: rm"), std::string::npos) << error.message;
    return error.message.find(what) != std::string::npos;
  }

  static constexpr uid_t unknown_sender = 65'534;
  static constexpr gid_t served = 60'100;
  test::TemporaryDirectory directory_;
  std::string path_ = directory_.path() / "file";
};

TEST_F(TrustedFileTest, AFileOfThisAccountIsOpened) {
  make_file();
  for (const int access : {O_RDONLY, O_RDWR}) EXPECT_TRUE(open_trusted_file(path_, access));
}

TEST_F(TrustedFileTest, AFileThatIsNotThereIsUnavailable) { EXPECT_EQ(refusal().code, Errc::unavailable); }

TEST_F(TrustedFileTest, AFifoIsRefusedWithoutWaitingForItsOtherEnd) {
  ASSERT_EQ(mkfifo(path_.c_str(), 0666), 0);
  for (const int access : {O_RDONLY, O_RDWR}) EXPECT_TRUE(refuses("it is a FIFO of user", access));
}

TEST_F(TrustedFileTest, ADirectoryIsRefused) {
  std::filesystem::create_directory(path_);
  for (const int access : {O_RDONLY, O_RDWR}) EXPECT_TRUE(refuses("it is a directory", access));
  EXPECT_TRUE(refuses("remove it: rm -r " + path_));
}

TEST_F(TrustedFileTest, ASocketIsRefused) {
  const FileDescriptor end(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path_.c_str(), sizeof address.sun_path - 1);
  ASSERT_EQ(bind(end.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  EXPECT_TRUE(refuses("it is a socket"));
}

TEST_F(TrustedFileTest, ALinkIsNotFollowed) {
  std::ofstream(directory_.path() / "other") << "mine";
  std::filesystem::create_symlink(directory_.path() / "other", path_);
  EXPECT_TRUE(refuses("it is a symbolic link"));
}

TEST_F(TrustedFileTest, AFileWithASecondNameIsRefused) {
  make_file();
  std::filesystem::create_hard_link(path_, directory_.path() / "other");
  EXPECT_TRUE(refuses("second name"));
}

TEST_F(TrustedFileTest, AFileOfAnotherAccountIsRefusedUnlessThatIsTrusted) {
  if (!make_file_of(unknown_sender, unknown_sender))
    GTEST_SKIP() << "needs root, to make files of other users";
  EXPECT_TRUE(refuses("belongs to " + account_name(unknown_sender)));
  EXPECT_TRUE(open_trusted_file(path_, O_RDWR, {.users = {unknown_sender}}));
  EXPECT_TRUE(open_trusted_file(path_, O_RDWR, {.everybody = true}));
  EXPECT_EQ(refusal(O_RDWR, {.users = {unknown_sender - 1}, .groups = {served}}).code, Errc::address_in_use);
}

TEST_F(TrustedFileTest, AFileOfATrustedGroupIsByOneOfItsMembers) {
  if (!make_file_of(unknown_sender, served)) GTEST_SKIP() << "needs root, to make files of other users";
  EXPECT_TRUE(open_trusted_file(path_, O_RDWR, {.groups = {served}}));
}

TEST_F(TrustedFileTest, RootAndThisAccountAreTrustedAnyway) {
  EXPECT_TRUE(TrustedAccounts{}.include_user(0));
  EXPECT_TRUE(TrustedAccounts{}.include_user(geteuid()));
  if (seteuid(unknown_sender) != 0) GTEST_SKIP() << "needs root, to become another user";
  EXPECT_TRUE(TrustedAccounts{}.include_user(0));
  EXPECT_TRUE(TrustedAccounts{}.include_user(unknown_sender));
  EXPECT_FALSE(TrustedAccounts{}.include_user(unknown_sender - 1));
  EXPECT_EQ(seteuid(0), 0);
}

TEST_F(TrustedFileTest, AFileThatThisAccountMayNotOpenIsForbidden) {
  make_file();
  ASSERT_EQ(chmod(directory_.path().c_str(), 0755), 0);
  ASSERT_EQ(chmod(path_.c_str(), 0600), 0);
  if (seteuid(unknown_sender) != 0) GTEST_SKIP() << "needs root, to become another user";
  const Error error = refusal();
  ASSERT_EQ(seteuid(0), 0);
  EXPECT_EQ(error.code, Errc::no_permission);
  EXPECT_NE(error.message.find(account_name(0)), std::string::npos) << error.message;
}

TEST_F(TrustedFileTest, ALinkInItsPlaceDoesNotNameWhatIsOpen) {
  make_file();
  const auto file = open_trusted_file(path_, O_RDONLY);
  std::filesystem::rename(path_, directory_.path() / "other");
  std::filesystem::create_symlink(directory_.path() / "other", path_);
  EXPECT_FALSE(still_names(path_, file->get()));
}

TEST_F(TrustedFileTest, APathNamesWhatIsOpenUntilItIsRemovedOrReplaced) {
  make_file();
  const auto file = open_trusted_file(path_, O_RDONLY);
  EXPECT_TRUE(still_names(path_, file->get()));
  unlink(path_.c_str());
  EXPECT_FALSE(still_names(path_, file->get()));
  make_file();
  EXPECT_FALSE(still_names(path_, file->get()));
}

}  // namespace
}  // namespace sft::core
