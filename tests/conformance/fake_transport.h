// A transport within the process: the plainest reading of core/seam, for tests of what is above the seam, and
// for whoever writes a transport of their own. It is a Network: it delivers copies, under each reader's mask,
// before send() returns. Nothing is ever late or lost.
//
// Its parts, in the order in which another transport would be made:
//
//   FakeTransport   opens ports and tells where its readers are reached. Here any address will do:
//   FakeNetwork
//                   finds readers by their ids.
//   FakeWriter      has one Line for each route: the fields that the reader asked for, its gate, its tally in
//                   the delivery book, and what waits for the reader until it was given its history.
//   FakeReader      is FakeInbox behind the seam: a queue of the newest samples of each writer, and the count
//                   of the samples that were pushed out of it.
//
// tests/conformance/fake_test.cpp shows how a transport is run through the suite, and fake_node_test.cpp how
// nodes are opened with it.
#pragma once

#include <cstddef>
#include <memory>

#include "core/seam/transport.h"

namespace sft::test {

/// The network that writers of some transports and readers of others share. Any thread.
class FakeNetwork;
std::shared_ptr<FakeNetwork> make_fake_network();

struct FakeOptions {
  std::size_t max_sample_bytes = std::size_t{1} << 20;  ///< of a body
  std::size_t pool_bytes = std::size_t{64} << 20;       ///< for what has arrived and is still held
};

/// Readers are found by the ids in the routes; where these say that they are does not matter. Listeners are
/// called by the thread that sends. Ports may outlive the transport; they do nothing then.
std::unique_ptr<core::Network> open_fake_transport(std::shared_ptr<FakeNetwork> network,
                                                   const FakeOptions& options = {});

}  // namespace sft::test
