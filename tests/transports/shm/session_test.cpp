// The session of a process with its daemon.
#include "shm_transport/host/session.h"

#include "shm_transport/daemon/process_daemon.h"
#include "tests/support/heap_bytes.h"
#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

/// A part of the session that goes at once, as a port that is closed.
struct ClosedPort final : shm::SessionMember {
  void lose(Loss) noexcept override {}
  bool sends() const noexcept override { return false; }
};

using ShmSession = ShmNodeTest;

TEST_F(ShmSession, KeepsNothingOfPortsThatWereClosed) {
  const auto session = shm::ProcessDaemon::shared()->advance(own_daemon(), Clock::now()).session;
  ASSERT_NE(session, nullptr);
  EXPECT_LT(bytes_left_by([&] { session->enlist(std::make_shared<ClosedPort>()); }), nothing_left);
}

}  // namespace
}  // namespace sft::test
