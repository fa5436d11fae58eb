// A process finds the daemon in three ways: by the host file, by the lock in /tmp, and by the daemon's
// socket.
#include <gtest/gtest.h>
#include <unistd.h>

#include <string>

#include "shm_transport/host/host_file.h"
#include "shm_transport/host/socket_address.h"
#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

class FoundHost : public ShmTest {
 protected:
  static constexpr uid_t other_account = 65'534;
  using Finding = shm::HostMonitor::Finding;
  static Finding found(const core::TrustedAccounts& accepted = {}) {
    return shm::HostMonitor::look(accepted).finding;
  }
};

TEST_F(FoundHost, IsAliveAsLongAsItsFileIsLocked) {
  EXPECT_EQ(found(), Finding::absent);
  auto lock = shm::FileLock::take(shm::host_file_path);
  ASSERT_TRUE(lock) << lock.error().message;
  EXPECT_EQ(found(), Finding::starting);
  const std::string text = shm::format({});
  ASSERT_EQ(write(lock->descriptor(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
  EXPECT_EQ(found(), Finding::alive);
  lock->unlock();
  EXPECT_EQ(found(), Finding::absent);
}

TEST_F(FoundHost, OfAnotherAccountIsForeignUnlessThatAccountIsAccepted) {
  const auto lock = shm::FileLock::take(shm::host_file_path);
  ASSERT_TRUE(lock) << lock.error().message;
  if (chown(shm::host_file_path, other_account, other_account) != 0)
    GTEST_SKIP() << "needs root, to give files away";
  EXPECT_EQ(found(), Finding::foreign);
  EXPECT_EQ(shm::HostMonitor::look({}).user, other_account);
  EXPECT_EQ(found({.users = {other_account}}), Finding::starting);
}

TEST_F(FoundHost, HasALockThatIsReadOnlyWhileItIsHeld) {
  auto lock = shm::FileLock::take(shm::daemon_lock_path);
  ASSERT_TRUE(lock) << lock.error().message;
  const std::string text = shm::format_lock({.pid = 12, .shm_device = 34});
  ASSERT_EQ(write(lock->descriptor(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
  const auto read = shm::read_daemon_lock();
  ASSERT_TRUE(read);
  EXPECT_EQ(read->pid, 12);
  EXPECT_EQ(read->shm_device, 34U);
  lock->unlock();
  EXPECT_FALSE(shm::read_daemon_lock());
}

TEST_F(FoundHost, HasASocketThatIsAliveOrGone) {
  const char* const path = "/tmp/sft_listener_test";
  EXPECT_EQ(shm::socket_state_at(path), shm::SocketState::gone);
  {
    const shm::Descriptor end(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    const sockaddr_un address = shm::socket_address(path);
    ASSERT_EQ(bind(end.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(shm::socket_state_at(path), shm::SocketState::alive);
  }
  EXPECT_EQ(shm::socket_state_at(path), shm::SocketState::gone) << "nobody listens there any more";
  unlink(path);
}

}  // namespace
}  // namespace sft::test
