// The thread that sends a sample: the publisher's thread, or the sending thread of the transport.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <span>
#include <thread>

#include "tests/support/other_threads.h"
#include "tests/transports/udp/endpoints.h"
#include "tests/transports/udp/faulty_io.h"
#include "tests/transports/udp/transport_fixture.h"

namespace sft::udp {
namespace {

using test::make_image;
using test::Publisher;
using test::Subscriber;

/// Counts the bytes that one thread sends.
class CountsBytesOfThread final : public test::Connected {
 public:
  CountsBytesOfThread(std::unique_ptr<Connection> inner, std::thread::id thread,
                      std::atomic<std::size_t>& bytes)
      : Connected(std::move(inner)), thread_(thread), bytes_(bytes) {}
  Sent try_send(std::span<const OutgoingBatch> batches) noexcept override {
    const Sent sent = Connected::try_send(batches);
    if (std::this_thread::get_id() != thread_) return sent;
    for (const OutgoingBatch& batch : batches.first(sent.batches)) {
      for (const iovec& part : batch.parts) bytes_ += part.iov_len;
    }
    return sent;
  }

 private:
  const std::thread::id thread_;
  std::atomic<std::size_t>& bytes_;
};

class WhoSendsTest : public TransportTest {
 protected:
  /// Returns the fraction of a sample that this thread sends while nothing else is under way. The sample is
  /// the second one. If the fraction is less than `least`, later samples are tried, up to number
  /// `samples_max`.
  double own_part(std::size_t bytes, bool asynchronous, double least = 0) {
    constexpr std::size_t samples_max = 50;
    std::atomic<std::size_t> own{0};
    const auto here = open();
    const auto there = open({}, [&own, publishers = std::this_thread::get_id()](DatagramIo io) {
      io.sender = std::make_unique<test::DecoratedSender>(
          std::move(io.sender), [&own, publishers](const SocketAddress&, std::unique_ptr<Connection> inner) {
            return std::make_unique<CountsBytesOfThread>(std::move(inner), publishers, own);
          });
      return io;
    });
    Subscriber subscriber(*here, {"*"});
    Publisher publisher(*there, Publisher::usual_id, 0, {}, asynchronous);
    subscriber.listen_to(publisher.id());
    publisher.serve({{test::loopback_address(*here)}});
    const auto part = [&] { return static_cast<double>(own) / static_cast<double>(bytes); };
    for (std::size_t n = 1; n <= 2 || (n <= samples_max && part() < least); ++n) {
      // The first sample waits for a report of the receiver.
      own = 0;
      publisher.publish(make_image(bytes));
      EXPECT_EQ(subscriber.await(n).size(), n);
      EXPECT_TRUE(test::eventually(sft::test::all_other_threads_sleep))
          << "the sending thread may not have put the sample away";
    }
    return part();
  }
};

INSTANTIATE_TEST_SUITE_P(Backends, WhoSendsTest, all_ways, way_name);

/// If the receiver was slow for one sample, the window is small after that, and grows again with later
/// samples.
TEST_P(WhoSendsTest, ThePublishersThreadSendsALargeSampleUntilTheWindowIsFull) {
  EXPECT_GT(own_part(2'000'000, false, 0.1), 0.1);
}

TEST_P(WhoSendsTest, ThePublishersThreadSendsNothingOfALargeSampleIfItIsAsynchronous) {
  EXPECT_LT(own_part(2'000'000, true), 0.001) << "only marks";
  EXPECT_LT(own_part(20'000, true), 0.01);
}

TEST_P(WhoSendsTest, ThePublishersThreadSendsAllOfASmallSampleAlsoIfItIsAsynchronous) {
  EXPECT_GT(own_part(1000, true), 0.9);
}

}  // namespace
}  // namespace sft::udp
