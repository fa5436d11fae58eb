// A transport is destroyed within its listener. The test is not run under the thread sanitizer. The
// sanitizer does not notice that liburing unmaps a ring, so it confuses the next ring at that address with
// the former one.
#include <gtest/gtest.h>
#include <netinet/in.h>

#include <atomic>
#include <memory>

#include "tests/transports/udp/endpoints.h"
#include "udp_transport/udp_transport.h"

namespace sft::udp {
namespace {

class TransportDestroying final : public core::ArrivalListener {
 public:
  void arrived() noexcept override {
    reader.reset();
    transport.reset();
    done = true;
  }
  std::unique_ptr<core::Network> transport;
  std::unique_ptr<core::NetworkReader> reader;
  std::atomic<bool> done{false};
};

TEST(SelfDestruction, OfATransportIsPossibleWithinItsListener) {
  for (const Backend backend : {Backend::automatic, Backend::sockets}) {
    for (int i = 0; i < 20; ++i) {
      auto transport =
          open_udp_transport({.bind_address = INADDR_LOOPBACK, .backend = backend}, test::make_pool())
              .value();
      test::Publisher publisher(*transport);
      publisher.serve({{test::loopback_address(*transport)}});
      TransportDestroying listener;
      listener.reader = transport
                            ->open_reader({.id = 1,
                                           .type = &test::type_support<test::Image>(),
                                           .depth = 1,
                                           .listener = &listener,
                                           .doorbell = {}})
                            .value();
      listener.reader->accept({{.wanted = {test::fields<test::Image>("*")}}});
      ASSERT_TRUE(listener.reader->connect({publisher.id(), 0}));
      listener.transport = std::move(transport);
      publisher.publish(test::make_image(10));
      ASSERT_TRUE(test::eventually([&] { return listener.done.load(); }));
    }
  }
}

}  // namespace
}  // namespace sft::udp
