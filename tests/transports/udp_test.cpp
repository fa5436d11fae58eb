// The suite on UDP, with both of its backends.
#include <netinet/in.h>

#include "conformance.h"
#include "tests/udp/endpoints.h"
#include "udp_transport/udp_transport.h"

namespace sft::conformance {
namespace {

class UdpMedium final : public Medium {
 public:
  explicit UdpMedium(udp::Backend backend) : backend_(backend) {}

  std::string refusal() override {
    const auto one = open_one(), other = open_one();
    if (one && other) return {};
    return "io_uring is refused here: " + (one ? other : one).error().message;
  }
  std::unique_ptr<core::Transport> open() override { return open_one().value(); }
  core::Locator locator(const core::Transport& node, const core::DoorbellAddress&) override {
    return udp::test::loopback_address(node);
  }

 private:
  /// Paced so that the sockets' small buffers on some machines can hold what comes.
  Result<std::unique_ptr<core::Transport>> open_one() {
    return udp::open_udp_transport(
        {.bind_address = INADDR_LOOPBACK, .backend = backend_, .pace_bytes_per_s = 100'000'000},
        udp::test::make_pool());
  }

  const udp::Backend backend_;
};

MediumChoice with(const char* name, udp::Backend backend) {
  return {name, [backend] { return std::make_unique<UdpMedium>(backend); }};
}

const auto both_backends =
    testing::Values(with("IoUring", udp::Backend::io_uring), with("Sockets", udp::Backend::sockets));

INSTANTIATE_TEST_SUITE_P(Udp, Conformance, both_backends, name_of);
INSTANTIATE_TEST_SUITE_P(Udp, LateReaders, both_backends, name_of);
INSTANTIATE_TEST_SUITE_P(Udp, Projection, both_backends, name_of);

}  // namespace
}  // namespace sft::conformance
