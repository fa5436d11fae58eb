// A transport within the process. It is the simplest implementation of core/seam, for tests of the code
// above the seam, and as a model for other transports. It is a Network, and delivers a copy under each
// reader's mask before send() returns. No sample is ever late or lost.
//
// The parts of the transport, in the order in which one would write another transport:
//
//   FakeTransport   opens ports, and returns the addresses of its readers. Any address will do here, because
//                   FakeNetwork finds readers by their ids.
//   FakeWriter      has one Line for each route: the fields that the reader requested, its gate, its tally in
//                   the delivery book, and the samples that wait until the reader has its history.
//   FakeReader      is the ReaderPort of a FakeInbox: a queue of the newest samples of each writer, and the
//                   count of the samples that were displaced from the queue.
//
// tests/conformance/fake_test.cpp shows how the suite tests a transport, and fake_node_test.cpp shows how
// nodes are opened on the fake transport.
#pragma once

#include <cstddef>
#include <memory>

#include "core/seam/transport.h"

namespace sft::test {

/// The network of several fake transports. On it the writers of one transport find the readers of another
/// transport. Any thread may call the network.
class FakeNetwork;
std::shared_ptr<FakeNetwork> make_fake_network();

struct FakeOptions {
  std::size_t max_sample_bytes = std::size_t{1} << 20;  ///< the largest body of a sample
  std::size_t pool_bytes = std::size_t{64} << 20;  ///< the memory for arrived samples that are still held
};

/// Opens a transport. The routes name readers by their ids; the addresses there are ignored. The sending
/// thread calls listeners. Ports may outlive the transport, but then do nothing.
std::unique_ptr<core::Network> open_fake_transport(std::shared_ptr<FakeNetwork> network,
                                                   const FakeOptions& options = {});

}  // namespace sft::test
