// The suite on the fake transport. The suite shows that the fake behaves like other transports, so that tests
// may rely on it.
#include "tests/conformance/conformance.h"
#include "tests/conformance/fake_transport.h"

namespace sft::conformance {
namespace {

using namespace detail;

class FakeMedium final : public Medium {
 public:
  AnyTransport open() override { return test::open_fake_transport(network_); }
  core::Locator locator(const AnyTransport&, const core::DoorbellAddress& bell) override { return bell; }

 private:
  const std::shared_ptr<test::FakeNetwork> network_ = test::make_fake_network();
};

const auto in_process = testing::Values(MediumChoice{"InProcess", std::make_unique<FakeMedium>});

INSTANTIATE_TEST_SUITE_P(Fake, Conformance, in_process, name_of);
INSTANTIATE_TEST_SUITE_P(Fake, LateReaders, in_process, name_of);
INSTANTIATE_TEST_SUITE_P(Fake, Projection, in_process, name_of);
INSTANTIATE_TEST_SUITE_P(Fake, Transmissions, in_process, name_of);

}  // namespace
}  // namespace sft::conformance
