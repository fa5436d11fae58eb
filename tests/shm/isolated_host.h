// A machine of its own for a test program: private /dev/shm and /tmp, and process ids that end with it. So
// tests neither meet a daemon that runs here nor leave one behind, however they end.
#pragma once

#include <string>

namespace sft::test {

inline constexpr const char* shm_size = "512m";

/// Moves this program there, and calls `run` in it. Where the system allows neither root nor user namespaces,
/// `run` is called where it stands, and isolation_refusal() says why.
int run_isolated(int (*run)());

/// Empty if the program is isolated: tests that need it skip by this otherwise.
const std::string& isolation_refusal();

/// A /dev/shm of another size, while it lives.
class ShmOfSize {
 public:
  explicit ShmOfSize(const char* size);
  ~ShmOfSize();
  ShmOfSize(const ShmOfSize&) = delete;
  ShmOfSize& operator=(const ShmOfSize&) = delete;
};

/// Directory of the test program, where sftd and shm_peer are too.
const std::string& program_directory();

}  // namespace sft::test
