// A transport within the process. It is the simplest implementation of core/seam, for tests of the code
// above the seam, and as a model for other transports. It is a Network: it delivers copies, under each
// reader's mask, before send() returns. No sample is ever late or lost.
//
// Its parts, in the order in which one would write another transport:
//
//   FakeTransport   opens ports, and says where its readers are reached. Any address will do here, because
//                   FakeNetwork finds readers by their ids.
//   FakeWriter      has one Line for each route: the fields that the reader asked for, its gate, its tally in
//                   the delivery book, and the samples that wait until the reader has its history.
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

/// The network by which the writers of several fake transports find the readers of others. Any thread.
class FakeNetwork;
std::shared_ptr<FakeNetwork> make_fake_network();

struct FakeOptions {
  std::size_t max_sample_bytes = std::size_t{1} << 20;  ///< largest body of a sample
  std::size_t pool_bytes = std::size_t{64} << 20;       ///< memory for arrived samples that are still held
};

/// Opens a transport. Readers are found by the ids in the routes; the addresses there are ignored. The
/// sending thread calls listeners. Ports may outlive the transport, but then do nothing.
std::unique_ptr<core::Network> open_fake_transport(std::shared_ptr<FakeNetwork> network,
                                                   const FakeOptions& options = {});

}  // namespace sft::test
