#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/other_threads.h"
#include "tests/support/test_seed.h"
#include "tests/transports/udp/endpoints.h"
#include "tests/transports/udp/faulty_io.h"
#include "tests/transports/udp/transport_fixture.h"
#include "udp_transport/io/interfaces.h"

namespace sft::udp {
namespace {

using test::encoded_body;
using test::eventually;
using test::fields;
using test::Image;
using test::loopback_address;
using test::make_image;
using test::Publisher;
using test::Subscriber;

void send_bytes(const core::UdpAddress& to, const std::vector<std::byte>& bytes) {
  const SystemAddress address({to.ip, to.port});
  const int fd = ::socket(address.family(), SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const std::byte none{};  // qemu-user refuses a null address, even for no bytes
  EXPECT_EQ(
      ::sendto(fd, bytes.empty() ? &none : bytes.data(), bytes.size(), 0, address.get(), address.bytes()),
      static_cast<ssize_t>(bytes.size()));
  ::close(fd);
}

INSTANTIATE_TEST_SUITE_P(Backends, TransportTest, all_ways, way_name);

TEST_P(TransportTest, SaysHowItWorks) {
  const auto transport = open();
  EXPECT_EQ(transport->max_sample_bytes(), std::size_t{64} << 20);
  EXPECT_EQ(transport->poll({}), core::Availability::ready);
  EXPECT_NE(
      transport->description().find(GetParam().backend == Backend::io_uring ? "io_uring" : "plain sockets"),
      std::string::npos)
      << transport->description();
  ASSERT_EQ(transport->addresses().size(), 1U);
  EXPECT_EQ(transport->addresses()[0].ip, GetParam().loopback);
  EXPECT_NE(transport->addresses()[0].port, 0);
  EXPECT_GT(transport->addresses()[0].receive_buffer_bytes, 0U);
}

TEST_P(TransportTest, SendsRetainedSamplesToOneReaderBeforeWhatComesMeanwhile) {
  const auto there = open(), here = open();
  Subscriber early(*here, {"data"}, 1000, 1);
  Subscriber late(*here, {"data"}, 1000, 2);
  Publisher publisher(*there);
  early.listen_to(publisher.id());
  late.listen_late_to(publisher.id());
  const FieldMask mask = fields<Image>("data");
  const core::Route to_early{1, loopback_address(*here), mask};
  core::Route to_late{2, loopback_address(*here), mask};
  to_late.history = 3;
  publisher.port().set_routes({to_early});
  std::vector<core::SampleHandle> retained;
  for (std::size_t i = 0; i < 3; ++i) retained.push_back(publisher.make(make_image(30'000 * i)));
  publisher.port().send(retained.back());

  publisher.port().set_routes({to_early, to_late});
  for (int i = 0; i < 2; ++i) publisher.publish(make_image(10));
  EXPECT_EQ(early.await_sequences(3), (std::vector<std::uint64_t>{3, 4, 5})) << "it waits for nobody";
  EXPECT_EQ(late.port().history(publisher.id()), core::HistoryProgress::awaited) << "it was not for it";
  publisher.port().send_history(to_late, retained);
  EXPECT_EQ(late.await_sequences(5), first_numbers(5));
  for (const core::SampleHandle& sample : late.await(5)) {
    EXPECT_EQ(sample->addressee, 2U);
    EXPECT_EQ(sample->oldest_retained, 1U);
  }
  EXPECT_TRUE(eventually([&] { return late.port().history(publisher.id()) == core::HistoryProgress::came; }));
  EXPECT_TRUE(eventually([&] { return publisher.port().history_sent(2); }));
  to_late.history = 0;
  publisher.port().set_routes({to_early, to_late});
  publisher.publish(make_image(10));
  EXPECT_EQ(late.await_sequences(6), first_numbers(6));
  EXPECT_EQ(early.await_sequences(4).back(), 6U);
}

TEST_P(TransportTest, RetainedSamplesAreNotAmongThoseThatPassedAGate) {
  const auto there = open(), here = open();
  Subscriber early(*here, {"data"}, 1000, 1);
  Subscriber late(*here, {"data"}, 1000, 2);
  Publisher publisher(*there);
  early.listen_to(publisher.id());
  late.listen_late_to(publisher.id());
  constexpr std::uint32_t period_us = 1000;
  const FieldMask mask = fields<Image>("data");
  for (Subscriber* subscriber : {&early, &late}) subscriber->port().accept({{.wanted = {mask, period_us}}});
  const auto gate = std::make_shared<core::Gate>(period_us);
  core::Route to_early{1, loopback_address(*here), mask, period_us, gate};
  core::Route to_late{2, loopback_address(*here), mask, period_us, gate, 2};
  publisher.port().set_routes({to_early});
  std::vector<core::SampleHandle> retained;
  const auto publish = [&](std::int64_t ms) {
    gate->consider(detail::FieldSource::of_nothing(), ms * 1'000'000);
    publisher.publish(make_image(10));
  };
  for (int i = 0; i < 2; ++i) retained.push_back(publisher.make(make_image(10)));
  for (int ms = 1; ms <= 3; ++ms) publish(ms);
  publisher.port().set_routes({to_early, to_late});
  publisher.port().send_history(to_late, retained);
  publish(4);
  const std::vector<core::SampleHandle> samples = late.await(3);
  ASSERT_EQ(samples.size(), 3U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(samples[i]->addressee, 2U);
    EXPECT_EQ(samples[i]->ordinal, 0U);
    EXPECT_EQ(samples[i]->min_period_us, 0U);
  }
  EXPECT_EQ(samples[2]->ordinal, 4U);
  EXPECT_EQ(samples[2]->min_period_us, period_us);
}

TEST_P(TransportTest, KeepsTheOrderOfALateReaderThatAsksForOtherFieldsMeanwhile) {
  const auto there = open({.max_bytes_per_s = 100'000'000}), here = open();
  Subscriber late(*here, {"*", "stamp"});
  Publisher publisher(*there);
  late.listen_late_to(publisher.id());
  core::Route to_late{1, loopback_address(*here), fields<Image>("*")};
  to_late.history = 10;
  std::vector<core::SampleHandle> retained;
  for (std::size_t i = 0; i < 10; ++i) retained.push_back(publisher.make(make_image(1'000'000)));
  publisher.port().set_routes({to_late});
  publisher.port().send_history(to_late, retained);
  to_late.selection = fields<Image>("stamp");
  publisher.port().set_routes({to_late});
  publisher.publish(make_image(10));
  EXPECT_EQ(late.await_sequences(11), first_numbers(11));
}

TEST_P(TransportTest, CarriesNoSampleBeyondTheLimit) {
  const auto there = open({.max_sample_bytes = 1000}), here = open();
  Publisher publisher(*there);
  publisher.serve({{loopback_address(*here)}});
  EXPECT_EQ(publisher.publish(make_image(2000)), core::SendStatus::dropped);
  EXPECT_EQ(there->counters().over_limit, 1U);
}

TEST_P(TransportTest, CarriesTrainsOfShortDatagrams) {
  const auto there = open({.max_datagram_bytes = 1472}), here = open();
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here)}});
  for (std::size_t n = 1; const std::size_t bytes : {1'000U, 10'000U, 150'000U, 60'000U}) {
    EXPECT_EQ(publisher.publish(make_image(bytes)), core::SendStatus::sent);
    const auto samples = subscriber.await(n);
    ASSERT_EQ(samples.size(), n);
    EXPECT_EQ(test::body_of(*samples.back()), encoded_body(make_image(bytes), fields<Image>("*")));
    ++n;
  }
}

TEST_P(TransportTest, SendsSingleDatagramsOnceTheWayOutRefusesTrains) {
  const auto here = open();
  for (const std::size_t bytes : {5'000U, 100'000U}) {
    const auto there = open({.max_datagram_bytes = 1472},
                            test::with_connections<test::TrainRefusingConnection<SendOutcome::no_segments>>);
    Subscriber subscriber(*here, {"*"});
    Publisher publisher(*there);
    subscriber.listen_to(publisher.id());
    publisher.serve({{loopback_address(*here)}});
    EXPECT_TRUE(eventually([&] {
      publisher.publish(make_image(bytes));
      return !subscriber.await(1, std::chrono::seconds(1)).empty();
    }));
  }
}

TEST_P(TransportTest, KeepsTheOrderOfLargeAndSmallSamples) {
  const auto there = open(), here = open();
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here)}});
  for (int i = 0; i < 30; ++i) {
    ASSERT_EQ(publisher.publish(make_image(i % 3 == 0 ? 300'000 : 50)), core::SendStatus::sent);
    if (i % 3 == 2) subscriber.await(static_cast<std::size_t>(i) + 1);
  }
  EXPECT_EQ(subscriber.await_sequences(30), first_numbers(30));
}

TEST_P(TransportTest, CountsWritersThatNobodyReadsAndBytesThatAreNoDatagram) {
  const auto there = open(), here = open();
  Publisher publisher(*there);
  publisher.serve({{loopback_address(*here)}});
  publisher.publish(make_image(10));
  EXPECT_TRUE(eventually([&] { return here->counters().unknown == 1; }));
  send_bytes(loopback_address(*here), std::vector<std::byte>(100));
  send_bytes(loopback_address(*here), {});
  EXPECT_TRUE(eventually([&] { return here->counters().malformed >= 1; }));
  Subscriber subscriber(*here, {"*"});
  subscriber.listen_to(publisher.id());
  publisher.publish(make_image(10));
  EXPECT_EQ(subscriber.await(1).size(), 1U) << "it goes on";
}

TEST_P(TransportTest, NamesAPortThatIsInUse) {
  const auto first = open();
  const std::uint16_t port = first->addresses()[0].port;
  const auto second = open_udp_transport(
      {.port = port, .bind_address = GetParam().loopback, .backend = GetParam()}, test::make_pool());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::address_in_use);
  EXPECT_NE(second.error().message.find(std::to_string(port)), std::string::npos) << second.error().message;
}

TEST_P(TransportTest, Hears64LivingWritersWithOneShortIdAndRefusesMore) {
  const auto here = open();
  Subscriber subscriber(*here, {"*"});
  subscriber.listen_to(0x1'0000'0007);
  for (core::EndpointId high = 2; high <= 64; ++high)
    EXPECT_TRUE(subscriber.port().connect({high << 32 | 7, 0})) << high;
  const Result<void> one_more = subscriber.port().connect({core::EndpointId{65} << 32 | 7, 0});
  ASSERT_FALSE(one_more);
  EXPECT_EQ(one_more.error().code, Errc::unavailable);
}

TEST_P(TransportTest, DeliversEachSampleOnceOrCountsIt) {
  const std::uint64_t seed = sft::test::test_seed();
  SCOPED_TRACE(sft::test::how_to_repeat());
  const auto there = open({.max_datagram_bytes = 1472});
  const auto here = open({.reassembly = {.timeout = std::chrono::milliseconds(20)}}, [&](DatagramIo io) {
    return test::with_faults(std::move(io), {.loss = 0.0005, .repetition = 0.1, .swap = 0.1},
                             static_cast<unsigned>(seed));
  });
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here)}});
  const auto lost = [&] {
    const auto counters = here->counters();
    return counters.incomplete + counters.over_limit + subscriber.port().counters().discarded;
  };
  for (std::uint64_t n = 1; n <= 100; ++n) {
    publisher.publish(make_image(500'000));
    ASSERT_TRUE(eventually([&] { return subscriber.await(0).size() + lost() == n; }))
        << subscriber.await(0).size() << " of " << n << " came, " << lost() << " were counted as lost";
  }
  const auto sequences = subscriber.await_sequences(0);
  EXPECT_TRUE(std::is_sorted(sequences.begin(), sequences.end()));
  EXPECT_EQ(std::adjacent_find(sequences.begin(), sequences.end()), sequences.end());
}

/// A single sample does not wait for further samples for its datagram, nor for another thread.
TEST_P(TransportTest, HandsASingleSampleToTheSystemBeforeItReturns) {
  const auto there = open(), here = open();
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here)}});
  const std::size_t body = encoded_body(make_image(10), fields<Image>("*")).size();
  publisher.publish(make_image(100'000));  // a large sample is sent only after its receiver has reported
  ASSERT_EQ(subscriber.await(1).size(), 1U);
  ASSERT_TRUE(eventually(sft::test::all_other_threads_sleep))
      << "the sending thread may not have put the large one away, which what follows must not overtake";
  for (std::size_t n = 2; n <= 101; ++n) {
    const std::uint64_t before = publisher.port().counters().bytes_sent;
    publisher.publish(make_image(10));
    ASSERT_GE(publisher.port().counters().bytes_sent - before, FirstHeader{}.bytes_in_single() + body) << n;
    ASSERT_EQ(subscriber.await(n).size(), n);
  }
}

}  // namespace
}  // namespace sft::udp
