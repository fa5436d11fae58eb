// Helpers for tests of shared memory: nodes that become ready, writers and readers of frames, and daemons
// and peers that a test starts, stops and kills.
#pragma once

#include <gtest/gtest.h>
#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/seam/transport.h"
#include "shm_transport/shm_transport.h"
#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"
#include "tests/support/shm_frame.h"

namespace sft::test {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// The user and the groups of a process. The user need not exist in /etc/passwd.
struct Identity {
  uid_t user;
  gid_t group;
  std::vector<gid_t> other_groups{};
};

/// Another program that the test starts. The destructor kills it.
class Process {
 public:
  explicit Process(const std::vector<std::string>& command, const Identity* as = nullptr);
  ~Process();
  Process(Process&& other) noexcept;
  Process& operator=(Process&&) = delete;

  pid_t pid() const { return pid_; }
  bool runs() const;
  void signal(int signal) const;
  void kill();
  /// Waits for the end of the process. Returns its exit code, or -1 if the process was killed.
  int exit_code();
  /// Returns the next line that the process writes, or an empty line if there is none within that time.
  std::string line(Clock::duration within = 30s);
  std::string all_output();

 private:
  void reap();
  pid_t pid_ = -1;
  int output_ = -1;
  int status_ = 0;
  std::string text_;
};

std::string sftd_path();
/// Starts shm_peer with these arguments, which shm_peer.cpp explains.
Process start_peer(std::vector<std::string> arguments);

/// Returns the process id of the running daemon, or 0 if no daemon runs.
pid_t daemon_pid();
/// Ends the running daemon, even if it is stopped, and waits until it has ended.
void end_daemon();
bool is_alive(pid_t pid);
/// Returns true if all threads of the process are stopped. This takes some time after SIGSTOP was sent.
bool is_stopped(pid_t pid);

shm::ShmOptions own_daemon();  ///< options with which a node starts the sftd of this build if none runs
shm::ShmOptions no_daemon();   ///< options with which a node starts no daemon
/// Returns the options of no_daemon() for a node that holds at most `samples` samples and loans.
shm::ShmOptions no_daemon_and_held_at_most(std::uint32_t samples);

/// The transport of one node.
class Node {
 public:
  explicit Node(const shm::ShmOptions& options = own_daemon());

  core::Availability poll() { return transport_->poll(Clock::now()); }
  bool becomes(core::Availability wanted, std::chrono::milliseconds within = 30s);
  bool becomes_ready() { return becomes(core::Availability::ready); }
  core::SharedMemory& transport() { return *transport_; }
  core::SharedMemory* operator->() { return transport_.get(); }

 private:
  std::unique_ptr<core::SharedMemory> transport_;
};

class Writer {
 public:
  /// Opens a port, with a route to a reader that does not exist. Without a route the port would deliver
  /// nothing.
  Writer(Node& node, core::EndpointId id);

  core::SampleHandle loan(std::uint32_t data);
  /// Fills in the next frame and sends it.
  core::SendStatus send(const core::SampleHandle& sample, std::uint32_t data);
  core::SendStatus send_frame(std::uint32_t data = 100);
  core::LendingWriter& port() { return *port_; }
  core::EndpointId id() const { return id_; }
  std::uint64_t sequence() const { return sequence_; }

 private:
  core::EndpointId id_;
  std::shared_ptr<core::LendingWriter> port_;
  std::uint64_t sequence_ = 0;
};

/// The id of the reader in most of these tests. Every writer serves this reader.
constexpr core::EndpointId reader_id = 7;

class Reader {
 public:
  explicit Reader(Node& node, std::uint32_t depth = 8, core::EndpointId id = reader_id,
                  std::uint64_t depth_bytes = 0);

  bool connects_to(core::EndpointId writer);
  core::SampleHandle take() { return port_->take(); }
  core::SampleHandle next(std::chrono::milliseconds within = 5s);
  core::BorrowingReader& port() { return *port_; }

 private:
  std::unique_ptr<core::BorrowingReader> port_;
};

inline std::uint64_t sequence_of(const core::SampleHandle& sample) { return sample->header().sequence; }

/// Counts the chunks for `data` bytes of data that a client of the daemon can take now.
class ChunkCounter {
 public:
  ChunkCounter(Node& node, std::uint32_t data) : node_(node), data_(data) {}
  std::size_t free();
  /// Returns true if at least `chunks` chunks become free in time. Otherwise prints the number of free
  /// chunks.
  bool comes_to(std::size_t chunks);

 private:
  Node& node_;
  std::uint32_t data_;
  std::vector<std::shared_ptr<core::LendingWriter>> ports_;
};

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::vector<std::string> names_in(const char* directory, const std::string& prefix = "");

/// Skips a test if there is no isolated host, and ends the daemon that a test leaves.
class ShmTest : public ::testing::Test {
 protected:
  /// `shm_mebibytes` is the size of /dev/shm; nothing means the usual size.
  explicit ShmTest(std::optional<unsigned> shm_mebibytes = {}) : shm_mebibytes_(shm_mebibytes) {}
  void SetUp() override;
  void TearDown() override;

 private:
  const std::optional<unsigned> shm_mebibytes_;
  std::optional<ShmOfSize> shm_;
};

/// A test with a node that is ready.
class ShmNodeTest : public ShmTest {
 protected:
  using ShmTest::ShmTest;
  void SetUp() override;
  void TearDown() override;
  Node& node() { return *node_; }
  void leave() { node_.reset(); }

 private:
  std::unique_ptr<Node> node_;
};

}  // namespace sft::test
