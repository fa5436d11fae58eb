// Receives the messages that nodes write on the control topics, and writes all of them again. Networks and
// caches may also repeat old messages, though not so many.
#pragma once

#include <memory>
#include <vector>

#include "core/discovery/discovery.h"

namespace sft::test {

class Echo final {
 public:
  Echo();

  /// Repeats all announcements and requests that have arrived so far, the oldest last. Then writes an
  /// announcement and the second request of a reader named "echo", which show other nodes that they have
  /// received all repeated messages.
  void repeat();

 private:
  std::vector<core::Endpoint> endpoints_;
  std::vector<core::Request> requests_;
  std::unique_ptr<core::Discovery> discovery_;
};

}  // namespace sft::test
