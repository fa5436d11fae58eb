// Reliable delivery between transports while datagrams are lost, repeated and swapped in both directions.
#include <gtest/gtest.h>
#include <netinet/in.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "tests/support/test_seed.h"
#include "tests/transports/udp/backends.h"
#include "tests/transports/udp/endpoints.h"
#include "tests/transports/udp/faulty_io.h"
#include "tests/transports/udp/transfers.h"
#include "udp_transport/flow/flow_limits.h"
#include "udp_transport/udp_transport.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using test::make_image;
using test::Publisher;
using test::Subscriber;

constexpr test::Faults bad_link{.loss = 0.05, .repetition = 0.01, .swap = 0.02};

class ReliableTest : public testing::TestWithParam<Backend> {
 protected:
  void SetUp() override {
    if (const std::string why = test::refusal_of(GetParam()); !why.empty()) GTEST_SKIP() << why;
  }

  /// Opens a transport with datagrams of 1,400 bytes, so that large samples need many datagrams.
  std::unique_ptr<core::Network> open(const test::Faults& faults = {}, UdpOptions options = {}) {
    options.bind_address = INADDR_LOOPBACK;
    options.backend = GetParam();
    if (options.max_datagram_bytes == datagram_bytes_max) options.max_datagram_bytes = 1400;
    const auto seed = static_cast<unsigned>(sft::test::test_seed());
    return open_udp_transport(options, test::make_pool(),
                              [&](DatagramIo io) { return test::with_faults(std::move(io), faults, seed); })
        .value();
  }

  /// Serves one reader reliably.
  void join(Publisher& publisher, Subscriber& subscriber, const core::Network& here) {
    subscriber.listen_reliably_to(publisher.id());
    publisher.serve({{test::loopback_address(here), "*", true}});
  }

  static std::vector<std::uint64_t> up_to(std::size_t count) {
    std::vector<std::uint64_t> all(count);
    std::iota(all.begin(), all.end(), 1);
    return all;
  }
};

INSTANTIATE_TEST_SUITE_P(Backends, ReliableTest, test::both_backends, test::backend_name);

TEST_P(ReliableTest, DeliversEverythingInOrderOverABadLink) {
  SCOPED_TRACE(sft::test::how_to_repeat());
  const auto there = open(bad_link), here = open(bad_link);
  Subscriber subscriber(*here, {"*"}, 5000);
  Publisher publisher(*there);
  join(publisher, subscriber, *here);
  for (std::size_t n = 1; n <= 2000; ++n) {
    ASSERT_EQ(publisher.publish(make_image(n)), core::SendStatus::sent) << n;
    if (n % 100 == 0) {
      ASSERT_GE(subscriber.await(n).size(), n);
    }
  }
  EXPECT_EQ(subscriber.await_sequences(2000), up_to(2000));
}

TEST_P(ReliableTest, DeliversTheLastSampleAlthoughNothingFollowsIt) {
  const auto there = open(), here = open({.loss = 0.5});
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  join(publisher, subscriber, *here);
  publisher.publish(make_image(5));
  EXPECT_EQ(subscriber.await_sequences(1), up_to(1));
}

/// Counts all received datagrams except marks.
class CountingReceiver final : public test::PassingReceiver {
 public:
  CountingReceiver(std::unique_ptr<DatagramReceiver> inner, std::atomic<std::size_t>& count)
      : PassingReceiver(std::move(inner)), count_(count) {}

 private:
  void datagram(std::span<const std::byte> bytes, const SocketAddress& from) noexcept override {
    if (kind_of(bytes) != DatagramKind::mark) ++count_;
    pass_on(bytes, from);
  }

  std::atomic<std::size_t>& count_;
};

TEST_P(ReliableTest, DeliversWhatGotLostAlsoIfTheReceiverHasNotAnsweredWhileItWasSentAllThatItMayBe) {
  std::atomic<bool> is_stalled{true};
  std::atomic<std::size_t> came{0};
  const auto there = open();
  const auto here =
      open_udp_transport({.bind_address = core::loopback_ipv4, .backend = GetParam()}, test::make_pool(),
                         [&](DatagramIo io) {
                           io.receiver = std::make_unique<CountingReceiver>(std::move(io.receiver), came);
                           return test::with_faults(std::move(io), {.loss = 1, .only_while = &is_stalled}, 1);
                         })
          .value();
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  join(publisher, subscriber, *here);
  for (std::size_t n = 1; n <= 12; ++n) ASSERT_EQ(publisher.publish(make_image(n)), core::SendStatus::sent);
  ASSERT_TRUE(test::eventually([&] { return came >= FlowLimits().unproven_datagrams; }, test::hang_timeout));
  is_stalled = false;
  EXPECT_EQ(subscriber.await_sequences(12), up_to(12));
}

TEST_P(ReliableTest, SendsReadersOfOneProcessOneCopyWhetherTheyAreReliableOrNot) {
  const auto there = open(), here = open();
  Subscriber careful(*here, {"*"}, 100, 1), careless(*here, {"*"}, 100, 2);
  Publisher publisher(*there);
  careful.listen_reliably_to(publisher.id());
  careless.listen_to(publisher.id());
  const core::UdpAddress address = test::loopback_address(*here);
  publisher.serve({{address, "*", true}, {address, "*", false}});
  for (int i = 0; i < 20; ++i) publisher.publish(make_image(50'000));
  EXPECT_EQ(careful.await_sequences(20), up_to(20));
  EXPECT_EQ(careless.await_sequences(20), up_to(20));
  EXPECT_LT(publisher.port().counters().bytes_sent, 20 * 53'000U);
}

TEST_P(ReliableTest, LosesNothingWhileTheMaskChanges) {
  SCOPED_TRACE(sft::test::how_to_repeat());
  const auto there = open(bad_link), here = open(bad_link);
  Subscriber subscriber(*here, {"*", "data", "stamp"}, 1000);
  Publisher publisher(*there);
  subscriber.listen_reliably_to(publisher.id());
  const std::vector<std::string> masks = {"*", "data", "stamp"};
  for (std::size_t n = 1; n <= 300; ++n) {
    publisher.serve({{test::loopback_address(*here), masks[n % masks.size()], true}});
    publisher.publish(make_image(n % 7 == 0 ? 100'000 : 50));
    if (n % 20 == 0) {
      ASSERT_GE(subscriber.await(n).size(), n);
    }
  }
  EXPECT_EQ(subscriber.await_sequences(300), up_to(300));
}

TEST_P(ReliableTest, FallsSilentOnceAllHasCome) {
  const auto there = open(), here = open();
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  join(publisher, subscriber, *here);
  for (int i = 0; i < 10; ++i) publisher.publish(make_image(50));
  EXPECT_EQ(subscriber.await_sequences(10), up_to(10));
  auto rests = [&, last = publisher.port().counters().bytes_sent,
                since = std::chrono::steady_clock::now()]() mutable {
    const auto now = std::chrono::steady_clock::now();
    if (const auto sent = publisher.port().counters().bytes_sent; std::exchange(last, sent) != sent)
      since = now;
    return now - since > 3s;
  };
  EXPECT_TRUE(test::eventually(rests));
}

/// A publisher that has retained samples, and a reader that is opened later.
class LateReaderTest : public ReliableTest {
 protected:
  /// Returns the sequences that a late reader gets if `retained` samples of `bytes` bytes are retained, and
  /// `live` samples follow. The publisher holds the retained samples, as on a reliable topic.
  std::vector<std::uint64_t> numbers_of(std::size_t retained, std::size_t bytes, std::size_t live = 0) {
    const auto there = open({}, full_length), here = open({}, full_length);
    const auto pool = core::BufferPool::make(std::size_t{512} << 20);
    Subscriber late(*here, {"*"}, 1000);
    Publisher publisher(*there);
    late.listen_late_to(publisher.id(), true);
    core::Route route{1, test::loopback_address(*here), test::fields<test::Image>("*")};
    route.reliable = true;
    route.history = static_cast<std::uint32_t>(retained);
    publisher.port().set_routes({route});
    std::vector<core::SampleHandle> samples;
    for (std::size_t i = 0; i < retained; ++i) samples.push_back(publisher.make(make_image(bytes), *pool));
    publisher.port().send_history(route, samples);
    for (std::size_t i = 0; i < live; ++i) publisher.port().send(publisher.make(make_image(bytes), *pool));
    std::vector<std::uint64_t> numbers;
    while (numbers.size() < retained + live) {
      const auto came = late.await_new(1);
      if (came.empty()) break;
      for (const core::SampleHandle& sample : came) numbers.push_back(sample->sequence);
    }
    return numbers;
  }
  static inline const UdpOptions full_length{.max_datagram_bytes = 65'000};
};

INSTANTIATE_TEST_SUITE_P(Backends, LateReaderTest, test::both_backends, test::backend_name);

TEST_P(LateReaderTest, GetsAllThatIsRetainedAlthoughAChannelCannotKeepItAllAtATime) {
  EXPECT_EQ(numbers_of(16, 6'000'000), up_to(16));
}

TEST_P(LateReaderTest, GetsAllThatIsRetainedWhateverItsSize) {
  EXPECT_EQ(numbers_of(6, 16'000'000), up_to(6));
  EXPECT_EQ(numbers_of(20, 3'000'000), up_to(20));
  EXPECT_EQ(numbers_of(60, 1'100'000), up_to(60));
  EXPECT_EQ(numbers_of(128, 600'000), up_to(128));
}

TEST_P(LateReaderTest, GetsWhatIsPublishedMeanwhileBehindWhatIsRetained) {
  EXPECT_EQ(numbers_of(16, 6'000'000, 4), up_to(20));
}

TEST_P(ReliableTest, TransfersAThousandSamplesOfAllSizesBitExactOverABadLink) {
  SCOPED_TRACE(sft::test::how_to_repeat());
  sft::test::Random random{sft::test::test_seed()};
  const auto there = open(bad_link), here = open(bad_link);
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  join(publisher, subscriber, *here);
  test::transfer_all_sizes(publisher, subscriber, random);
}

}  // namespace
}  // namespace sft::udp
