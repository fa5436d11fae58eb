// The suite on UDP with both of its backends: best-effort over IPv4 and IPv6, and reliable over a link that
// loses, repeats and swaps datagrams.
#include "tests/conformance/conformance.h"
#include "tests/support/test_seed.h"
#include "tests/transports/udp/backends.h"
#include "tests/transports/udp/endpoints.h"
#include "tests/transports/udp/faulty_io.h"
#include "udp_transport/udp_transport.h"

namespace sft::conformance {
namespace {

using namespace detail;

class UdpMedium final : public Medium {
 public:
  enum class Link : std::uint8_t { good, bad };
  UdpMedium(udp::Backend backend, Link link, const core::IpAddress& loopback)
      : backend_(backend), link_(link), loopback_(loopback) {}

  std::string refusal() override {
    if (!loopback_.is_ipv4() && !udp::test::has_ipv6_loopback()) return "there is no IPv6 here";
    return udp::test::refusal_of(backend_);
  }
  Traits traits() const override { return {.reliable = link_ == Link::bad}; }
  AnyTransport open() override {
    return udp::open_udp_transport({.bind_address = loopback_, .backend = backend_}, udp::test::make_pool(),
                                   [this](udp::DatagramIo io) {
                                     if (link_ == Link::good) return io;
                                     const auto seed = static_cast<unsigned>(test::test_seed());
                                     return udp::test::with_faults(
                                         std::move(io), {.loss = 0.02, .repetition = 0.01, .swap = 0.01},
                                         seed);
                                   })
        .value();
  }
  core::Locator locator(const AnyTransport& node, const core::DoorbellAddress&) override {
    return udp::test::loopback_address(*node.network());
  }

 private:
  const udp::Backend backend_;
  const Link link_;
  const core::IpAddress loopback_;
};

MediumChoice with(const char* name, udp::Backend backend, UdpMedium::Link link,
                  const core::IpAddress& loopback = core::loopback_ipv4) {
  return {name, [=] { return std::make_unique<UdpMedium>(backend, link, loopback); }};
}

const auto both_backends =
    testing::Values(with("IoUring", udp::Backend::io_uring, UdpMedium::Link::good),
                    with("Sockets", udp::Backend::sockets, UdpMedium::Link::good),
                    with("IoUringIPv6", udp::Backend::io_uring, UdpMedium::Link::good, core::loopback_ipv6),
                    with("SocketsIPv6", udp::Backend::sockets, UdpMedium::Link::good, core::loopback_ipv6),
                    with("ReliableIoUring", udp::Backend::io_uring, UdpMedium::Link::bad),
                    with("ReliableSockets", udp::Backend::sockets, UdpMedium::Link::bad));

INSTANTIATE_TEST_SUITE_P(Udp, Conformance, both_backends, name_of);
INSTANTIATE_TEST_SUITE_P(Udp, BackPressure,
                         testing::Values(with("IoUring", udp::Backend::io_uring, UdpMedium::Link::bad),
                                         with("Sockets", udp::Backend::sockets, UdpMedium::Link::bad)),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Udp, LateReaders, both_backends, name_of);
INSTANTIATE_TEST_SUITE_P(Udp, Projection, both_backends, name_of);
INSTANTIATE_TEST_SUITE_P(Udp, Transmissions, both_backends, name_of);

}  // namespace
}  // namespace sft::conformance
