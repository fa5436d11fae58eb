// Two hosts joined by a network, for one benchmark.
#pragma once

#include <functional>

#include "bench/common/pair.h"
#include "examples/demo/network.h"

namespace sft::bench {

/// Needs root; ends the program with a message where that is missing.
class TwoHosts {
 public:
  TwoHosts();

  /// The sender runs on the first host, the receiver on the second.
  Sides sides(std::function<void(Exchange&)> sender, std::function<void(Exchange&)> receiver) const;

  /// Of the second host, as a number in network byte order.
  static std::uint32_t receiver_address();

 private:
  demo::EmulatedNetwork network_;
};

/// Bytes that the calling process's eth0 has received and sent, with link-layer headers.
struct LinkBytes {
  std::int64_t received = 0;
  std::int64_t sent = 0;
};
LinkBytes link_bytes();

}  // namespace sft::bench
