// A cable between two hosts. A process forwards each frame from one end to the other. While the faults are
// switched on (`bad`), the process drops some frames, sends some frames twice, and swaps some frames with
// the next one. It records the samples that were affected.
#pragma once

#include <sys/types.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/system/node_process.h"
#include "tools/hosts/network.h"

namespace sft::test {

class LossyCable {
 public:
  struct Faults {
    double loss = 0.05;
    double repetition = 0.01;
    double swap = 0.01;
  };
  /// Makes two hosts and the cable between them. Each host has an interface eth0 (MTU 1500).
  static Result<std::unique_ptr<LossyCable>> create(const Faults& faults, std::uint64_t seed);
  ~LossyCable();
  LossyCable(const LossyCable&) = delete;
  LossyCable& operator=(const LossyCable&) = delete;

  const hosts::NetworkNamespace& host(std::size_t number) const { return hosts_[number]; }

  void become(bool bad) { notes_->bad = bad; }

  static constexpr std::size_t samples_max = 4096;
  /// The state of the cable, and its faults so far.
  struct Notes {
    std::atomic<bool> ready{false}, bad{false};
    std::atomic<std::uint64_t> lost{0}, repeated{0}, swapped{0};  ///< the numbers of frames
    /// The number of frames that the kernel dropped or refused. These losses are not intended.
    std::atomic<std::uint64_t> failed{0};
    /// For each sequence, true if the cable has lost a part of a sample with that sequence, of any
    /// publisher.
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
