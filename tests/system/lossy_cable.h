// A cable between two hosts, frame by frame in the hands of a process: while it is bad it loses some of them,
// passes some on twice, and some behind the next one. It notes which samples it did harm to.
#pragma once

#include <sys/types.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tools/hosts/network.h"
#include "tests/system/node_process.h"

namespace sft::test {

class LossyCable {
 public:
  struct Faults {
    double loss = 0.05;
    double repetition = 0.01;
    double swap = 0.01;
  };
  /// Two new hosts and what is between them; each has an interface eth0 (MTU 1500).
  static Result<std::unique_ptr<LossyCable>> create(const Faults& faults, std::uint64_t seed);
  ~LossyCable();
  LossyCable(const LossyCable&) = delete;
  LossyCable& operator=(const LossyCable&) = delete;

  const hosts::NetworkNamespace& host(std::size_t number) const { return hosts_[number]; }

  void become(bool bad) { notes_->bad = bad; }

  static constexpr std::size_t samples_max = 4096;
  /// Counts what the cable did since it was made.
  struct Notes {
    std::atomic<bool> ready{false}, bad{false};
    std::atomic<std::uint64_t> lost{0}, repeated{0}, swapped{0};  ///< frames
    /// Frames that the kernel had no room for, or would not take: nobody asked for that.
    std::atomic<std::uint64_t> failed{0};
    /// Sequences of which it lost a part, of whatever publisher there is.
    std::array<std::atomic<bool>, samples_max> harmed{};
  };
  const Notes& notes() const { return *notes_; }

 private:
  LossyCable(hosts::NetworkNamespace middle, std::vector<hosts::NetworkNamespace> hosts)
      : middle_(std::move(middle)), hosts_(std::move(hosts)) {}
  Result<void> plug_in(std::size_t number) const;
  [[noreturn]] void pass_on(const Faults& faults, std::uint64_t seed);

  hosts::NetworkNamespace middle_;
  std::vector<hosts::NetworkNamespace> hosts_;
  SharedWithChildren<Notes> notes_;
  pid_t process_ = -1;
};

}  // namespace sft::test
