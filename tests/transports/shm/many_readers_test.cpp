// A writer with many attached queues. The queues of readers that the writer serves in shared memory get each
// sample. The other queues get none.
#include "tests/transports/shm/many_readers.h"

#include <atomic>
#include <numeric>
#include <stop_token>
#include <thread>

#include "tests/support/test_seed.h"

namespace sft::test {
namespace {

using core::SampleHandle;
using core::SendStatus;

class ServedReaders : public ManyReaders {
 protected:
  /// Returns services in which a random number of readers, from none to nearly all, is not served.
  static Services random_services(Random& random) {
    Services services(readers);
    const std::uint64_t share = random() % 16;
    for (Service& service : services) service.is_served = random() % 16 >= share;
    return services;
  }
  /// Sends that number of samples, and returns their sequences.
  Sequences send(std::size_t count) {
    Sequences sent(count);
    std::iota(sent.begin(), sent.end(), writer_->sequence() + 1);
    for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(writer_->send_frame(), SendStatus::sent);
    return sent;
  }
  /// Expects each served reader to have got exactly the samples `sent`, and each other reader none.
  void expect_taken(const Services& services, const Sequences& sent) {
    for (std::size_t i = 0; i < readers; ++i)
      ASSERT_EQ(take_all(i), services[i].is_served ? sent : Sequences()) << "reader " << i;
  }
  void expect_nothing_discarded() {
    for (const auto& reader : readers_) EXPECT_EQ(reader->port().counters().discarded, 0U);
    EXPECT_EQ(node()->counters().malformed, 0U);
  }
};

TEST_F(ServedReaders, GetEachSampleAndAReaderBesideThemThatIsNotServedGetsNone) {
  for (const std::size_t unserved : {std::size_t{0}, readers / 2, readers - 1}) {
    serve_all_but({unserved});
    Services services(readers);
    services[unserved].is_served = false;
    ASSERT_NO_FATAL_FAILURE(expect_taken(services, send(depth))) << "without reader " << unserved;
  }
  EXPECT_TRUE(nobody_holds_a_sample());
  expect_nothing_discarded();
}

TEST_F(ServedReaders, ShareTheOneSampleThatWasSent) {
  serve_all_but({1, 17, 40, 41, 42, 63});
  const SampleHandle sent = writer_->loan(100);
  ASSERT_EQ(writer_->send(sent, 100), SendStatus::sent);
  std::size_t shared = 0;
  for (const auto& reader : readers_) {
    const SampleHandle sample = reader->take();
    shared += sample && sample->data == sent->data ? 1 : 0;
  }
  EXPECT_EQ(shared, readers - 6);
}

/// In each round different readers are served in shared memory, and the other readers over the network.
TEST_F(ServedReaders, GetNoSampleOfTheTimeWhenTheyWereNotServed) {
  SCOPED_TRACE(how_to_repeat());
  Random random{test_seed()};
  for (std::uint64_t round = 0; round < test_rounds(100); ++round) {
    const Services services = random_services(random);
    serve(services);
    ASSERT_NO_FATAL_FAILURE(expect_taken(services, send(1 + random() % 3))) << "round " << round;
  }
  serve_all_but({});
  EXPECT_TRUE(nobody_holds_a_sample());
  expect_nothing_discarded();
}

/// Every fourth reader is not served, and every fourth reader has no conditions.
TEST_F(ServedReaders, WithConditionsGetJustWhatPassesBesideOthersThatAreNotServed) {
  const auto second = gate("every 2nd"), third = gate("every 3rd");
  Services services(readers);
  for (std::size_t i = 0; i < readers; ++i)
    services[i] = {.is_served = i % 4 != 0, .gate = i % 4 == 2 ? second : i % 4 == 3 ? third : nullptr};
  serve(services);
  for (const auto& one : {second, third}) one->reader_begins();
  std::vector<Sequences> expected(4);
  for (std::uint64_t sequence = 1; sequence <= depth; ++sequence) {
    for (const auto& one : {second, third}) {
      one->consider(detail::FieldSource::of_nothing(), static_cast<std::int64_t>(sequence));
      one->made(detail::FieldSource::of_nothing(), static_cast<std::int64_t>(sequence));
    }
    ASSERT_EQ(writer_->send_frame(), SendStatus::sent);
    expected[1].push_back(sequence);
    if (sequence % 2 == 1) expected[2].push_back(sequence);
    if (sequence % 3 == 1) expected[3].push_back(sequence);
  }
  for (std::size_t i = 0; i < readers; ++i) EXPECT_EQ(take_all(i), expected[i % 4]) << "reader " << i;
  expect_nothing_discarded();
}

/// A third of the readers is always served, a third is never served, and a third is served now and then.
TEST_F(ServedReaders, NoticeNothingOfOthersThatComeAndGoMeanwhile) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "the thread sanitizer does not see the synchronisation in iceoryx's library";
#endif
  constexpr std::uint64_t samples = 500;
  std::atomic<std::uint64_t> changes{0};
  const auto serve_some = [&](bool also_the_last) {
    Services services(readers);
    for (std::size_t i = 0; i < readers; ++i)
      services[i].is_served = i % 3 == 0 || (i % 3 == 2 && also_the_last);
    serve(services);
    ++changes;
  };
  serve_some(false);
  const std::jthread agent([&](const std::stop_token& stop) {
    for (bool also_the_last = true; !stop.stop_requested(); also_the_last = !also_the_last)
      serve_some(also_the_last);
  });
  Sequences last(readers, 0);
  for (std::uint64_t sequence = 1; sequence <= samples || changes < 100; ++sequence) {
    ASSERT_EQ(writer_->send_frame(), SendStatus::sent);
    for (std::size_t i = 0; i < readers; ++i) {
      const Sequences taken = take_all(i);
      const bool has_it = taken == Sequences{sequence};
      ASSERT_TRUE(i % 3 == 0 ? has_it : taken.empty() || (i % 3 == 2 && has_it)) << "reader " << i;
    }
  }
  expect_nothing_discarded();
}

}  // namespace
}  // namespace sft::test
