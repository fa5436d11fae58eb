// A transport within the process, for tests of what is above the seam and as the plainest reading of
// core/seam/transport.h: it delivers, under each reader's mask, before send() returns; nothing is ever late
// or lost.
#pragma once

#include <cstddef>
#include <memory>

#include "core/seam/transport.h"

namespace sft::test {

/// What the writers of some transports share with the readers of others. Any thread.
class FakeNetwork;
std::shared_ptr<FakeNetwork> make_fake_network();

struct FakeOptions {
  std::size_t max_sample_bytes = std::size_t{1} << 20;  ///< of a body
  std::size_t pool_bytes = std::size_t{64} << 20;       ///< for what has arrived and is still held
};

/// Readers are found by the ids in the routes; where these say that they are does not matter. Listeners are
/// called by the thread that sends. Ports may outlive the transport; they do nothing then.
std::unique_ptr<core::Transport> open_fake_transport(std::shared_ptr<FakeNetwork> network,
                                                     const FakeOptions& options = {});

}  // namespace sft::test
