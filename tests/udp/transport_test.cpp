#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <numeric>
#include <thread>

#include "datagrams.h"
#include "endpoints.h"
#include "faulty_io.h"
#include "tests/support/test_seed.h"
#include "udp_transport/udp_transport.h"

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

class TransportTest : public testing::TestWithParam<Backend> {
 protected:
  void SetUp() override {
    const auto one = open_udp_transport({.backend = GetParam()}, test::make_pool());
    const auto other = open_udp_transport({.backend = GetParam()}, test::make_pool());
    if (!one || !other) GTEST_SKIP() << "io_uring is refused here: " << (one ? other : one).error().message;
  }

  std::unique_ptr<core::Transport> open(UdpOptions options = {}, const DecorateIo& decorate = {}) {
    options.backend = GetParam();
    options.bind_address = INADDR_LOOPBACK;
    return open_udp_transport(options, test::make_pool(), decorate).value();
  }

  static std::vector<std::uint64_t> first_numbers(std::size_t n) {
    std::vector<std::uint64_t> numbers(n);
    std::iota(numbers.begin(), numbers.end(), 1);
    return numbers;
  }

  static void send_bytes(const core::UdpAddress& to, const std::vector<std::byte>& bytes) {
    const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(to.port);
    address.sin_addr.s_addr = htonl(to.ipv4);
    EXPECT_EQ(
        ::sendto(fd, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&address), sizeof address),
        static_cast<ssize_t>(bytes.size()));
    ::close(fd);
  }
};

INSTANTIATE_TEST_SUITE_P(Backends, TransportTest, testing::Values(Backend::io_uring, Backend::sockets),
                         [](const auto& param) {
                           return param.param == Backend::io_uring ? "IoUring" : "Sockets";
                         });

TEST_P(TransportTest, SaysHowItWorks) {
  const auto transport = open();
  EXPECT_EQ(transport->max_sample_bytes(), std::size_t{32} << 20);
  EXPECT_EQ(transport->poll({}), core::Availability::ready);
  EXPECT_NE(transport->description().find(GetParam() == Backend::io_uring ? "io_uring" : "plain sockets"),
            std::string::npos)
      << transport->description();
  ASSERT_EQ(transport->addresses().size(), 1U);
  EXPECT_EQ(transport->addresses()[0].ipv4, INADDR_LOOPBACK);
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

TEST_P(TransportTest, KeepsTheOrderOfALateReaderThatAsksForOtherFieldsMeanwhile) {
  const auto there = open({.pace_bytes_per_s = 100'000'000}), here = open();
  Subscriber late(*here, {"*", "stamp"});
  Publisher publisher(*there);
  late.listen_late_to(publisher.id());
  core::Route to_late{1, loopback_address(*here), fields<Image>("*")};
  to_late.history = 10;
  std::vector<core::SampleHandle> retained;
  for (std::size_t i = 0; i < 10; ++i) retained.push_back(publisher.make(make_image(1'000'000)));
  publisher.port().set_routes({to_late});
  publisher.port().send_history(to_late, retained);
  to_late.mask = fields<Image>("stamp");
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

/// Readers behind one socket, each with a mask of its own.
class Audience {
 public:
  explicit Audience(core::Transport& here) : here_(here) {
    for (const char* scalar : {"", "stamp", "height", "stamp.sec, width"}) {
      for (const char* text : {"", ", name"}) {
        for (const char* bytes : {"", ", data"}) masks_.push_back(std::string(scalar) + text + bytes);
      }
    }
  }

  void ask(Publisher& publisher) {
    for (const std::string& mask : masks_) {
      subscribers_.push_back(std::make_unique<Subscriber>(here_, std::vector<std::string>{mask}));
      subscribers_.back()->listen_to(publisher.id());
      readers_.push_back({loopback_address(here_), mask});
    }
    publisher.serve(readers_);
  }
  /// The last ones become the first.
  void ask_in_reverse(Publisher& publisher) {
    std::reverse(readers_.begin(), readers_.end());
    publisher.serve(readers_);
  }

  const std::vector<std::string>& masks() const { return masks_; }
  Subscriber& subscriber(std::size_t number) { return *subscribers_[number]; }
  /// Whether each, in the end, has had these and no others.
  void expect_sequences(const std::vector<std::uint64_t>& sequences) {
    for (std::size_t i = 0; i < masks_.size(); ++i)
      EXPECT_EQ(subscribers_[i]->await_sequences(sequences.size()), sequences) << masks_[i];
  }

 private:
  core::Transport& here_;
  std::vector<std::string> masks_;
  std::vector<std::unique_ptr<Subscriber>> subscribers_;
  std::vector<Publisher::Reader> readers_;
};

TEST_P(TransportTest, SendsEachReaderItsFields) {
  const auto there = open(), here = open();
  Publisher publisher(*there);
  Audience audience(*here);
  audience.ask(publisher);
  for (std::size_t n = 1; const std::size_t bytes : {10U, 20'000U, 1000U}) {
    EXPECT_EQ(publisher.publish(make_image(bytes)), core::SendStatus::sent);
    for (std::size_t i = 0; const std::string& mask : audience.masks()) {
      const auto samples = audience.subscriber(i++).await(n);
      ASSERT_EQ(samples.size(), n) << mask;
      EXPECT_EQ(test::body_of(*samples.back()), encoded_body(make_image(bytes), fields<Image>(mask))) << mask;
    }
    ++n;
  }
}

TEST_P(TransportTest, KeepsTheOrderUnderMoreMasksThanThePublishersThreadEncodes) {
  const auto there = open({.send_queue_depth = 100}), here = open();
  Publisher publisher(*there);
  Audience audience(*here);
  audience.ask(publisher);
  for (int i = 0; i < 60; ++i) {
    ASSERT_EQ(publisher.publish(make_image(i % 20 == 0 ? 60'000 : 50)), core::SendStatus::sent);
    audience.ask_in_reverse(publisher);
  }
  audience.expect_sequences(first_numbers(60));
}

TEST_P(TransportTest, SendsUnderAllMasksAfterThePublisherWent) {
  const auto there = open(), here = open();
  Audience audience(*here);
  {
    Publisher publisher(*there);
    audience.ask(publisher);
    for (int i = 0; i < 3; ++i) publisher.publish(make_image(100'000));
  }
  audience.expect_sequences(first_numbers(3));
}

/// Where the kernel grants little memory to a socket, some may get lost.
TEST_P(TransportTest, SendsLargeSamplesOfOneWriterOneAfterAnother) {
  const auto there = open({.pace_bytes_per_s = 100'000'000});
  const auto here = open({.reassembly = {.unfinished_per_writer = 2}});
  Publisher publisher(*there);
  Audience audience(*here);
  audience.ask(publisher);
  EXPECT_TRUE(eventually([&] {
    publisher.publish(make_image(1'000'000));
    bool all = true;
    for (std::size_t i = 0; i < audience.masks().size(); ++i)
      all &= !audience.subscriber(i).await(1, std::chrono::seconds(2)).empty();
    return all;
  }));
}

TEST_P(TransportTest, SendsReadersOfOneProcessOneCopy) {
  const auto there = open(), here = open();
  Subscriber one(*here, {"data"}), other(*here, {"data"});
  Publisher publisher(*there);
  one.listen_to(publisher.id());
  other.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here), "data"}, {loopback_address(*here), "data"}});
  publisher.publish(make_image(1000));
  EXPECT_EQ(one.await(1).size(), 1U);
  EXPECT_EQ(other.await(1).size(), 1U);
  EXPECT_EQ(publisher.port().bytes_sent(), first_header_bytes + 4 + 1000);
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

TEST_P(TransportTest, QueuesSamplesWhileTheSendBufferIsFull) {
  const auto here = open();
  const auto there = open({.send_queue_depth = 100}, test::with_connections<test::BusyConnection>);
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here)}});
  for (int i = 0; i < 50; ++i) ASSERT_EQ(publisher.publish(make_image(50)), core::SendStatus::sent);
  EXPECT_EQ(subscriber.await_sequences(50), first_numbers(50));
  publisher.publish(make_image(1'000'000));  // of which each call sends a part
  ASSERT_EQ(subscriber.await(51).size(), 51U);
  EXPECT_EQ(test::body_of(*subscriber.await(51)[50]),
            encoded_body(make_image(1'000'000), fields<Image>("*")));
}

TEST_P(TransportTest, DropsTheOldestOfAFullQueueAndSaysSo) {
  const auto here = open();
  test::Gate gate(loopback_address(*here).port);
  const auto there =
      open({.send_queue_depth = 2}, [&](DatagramIo io) { return gate.put_around(std::move(io)); });
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here)}});
  EXPECT_EQ(publisher.publish(make_image(100'000)), core::SendStatus::sent);
  ASSERT_TRUE(eventually([&] { return gate.somebody_waits(); }));
  EXPECT_EQ(publisher.publish(make_image(100'000)), core::SendStatus::sent);
  EXPECT_EQ(publisher.publish(make_image(100'000)), core::SendStatus::sent);
  EXPECT_EQ(publisher.publish(make_image(100'000)), core::SendStatus::dropped);
  EXPECT_EQ(there->counters().over_limit, 1U);
  gate.open();
  EXPECT_EQ(subscriber.await_sequences(3), (std::vector<std::uint64_t>{1, 3, 4}));
}

TEST_P(TransportTest, LetsOneDestinationFallBehindAlone) {
  const auto slow = open(), fast = open();
  test::Gate gate(loopback_address(*slow).port);
  const auto there = open({}, [&](DatagramIo io) { return gate.put_around(std::move(io)); });
  Subscriber slow_one(*slow, {"*"}), fast_one(*fast, {"*"});
  Publisher publisher(*there);
  slow_one.listen_to(publisher.id());
  fast_one.listen_to(publisher.id());
  publisher.serve({{loopback_address(*slow)}, {loopback_address(*fast)}});
  for (std::size_t n = 1; n <= 20; ++n) {
    publisher.publish(make_image(n % 2 == 0 ? 50 : 100'000));
    ASSERT_EQ(fast_one.await(n, std::chrono::seconds(2)).size(), n);
    if (n == 1) {
      ASSERT_TRUE(eventually([&] { return gate.somebody_waits(); }));
    }
  }
  EXPECT_EQ(fast_one.await_sequences(20), first_numbers(20));
  EXPECT_EQ(there->counters().over_limit, 15U) << "all but the one being sent and the 4 queued";
  gate.open();
  EXPECT_EQ(slow_one.await_sequences(5), (std::vector<std::uint64_t>{1, 17, 18, 19, 20}));
}

TEST_P(TransportTest, CountsWhatItDropsAfterItTookIt) {
  const auto here = open();
  const auto there = open({.max_datagram_bytes = 1472},
                          test::with_connections<test::TrainRefusingConnection<SendOutcome::failed>>);
  Publisher publisher(*there);
  publisher.serve({{loopback_address(*here)}});
  EXPECT_EQ(publisher.publish(make_image(100'000)), core::SendStatus::sent);
  EXPECT_TRUE(eventually([&] { return publisher.port().dropped() == 1; }));
}

TEST_P(TransportTest, DropsASampleThatCannotLeaveForLong) {
  const auto here = open();
  test::Gate gate(loopback_address(*here).port);
  const auto there = open({}, [&](DatagramIo io) { return gate.put_around(std::move(io)); });
  Publisher publisher(*there);
  publisher.serve({{loopback_address(*here)}});
  EXPECT_EQ(publisher.publish(make_image(10)), core::SendStatus::sent);
  EXPECT_TRUE(eventually([&] { return publisher.port().dropped() == 1; }));
}

TEST_P(TransportTest, LetsGoOfWhatIsQueuedForADestinationThatLeft) {
  const auto here = open();
  test::Gate gate(loopback_address(*here).port);
  const auto there = open({}, [&](DatagramIo io) { return gate.put_around(std::move(io)); });
  Publisher publisher(*there);
  publisher.serve({{loopback_address(*here)}});
  const auto pool = core::BufferPool::make(150'000);
  ASSERT_EQ(publisher.publish(make_image(100'000), *pool), core::SendStatus::sent);
  ASSERT_TRUE(eventually([&] { return gate.somebody_waits(); }));
  EXPECT_FALSE(pool->take(100'000)) << "it is being sent";
  publisher.serve({});
  EXPECT_TRUE(eventually([&] { return static_cast<bool>(pool->take(100'000)); }));
  EXPECT_EQ(publisher.port().dropped(), 0U) << "nobody misses it";
}

TEST_P(TransportTest, SendsWhatIsQueuedAfterThePublisherWent) {
  const auto here = open();
  test::Gate gate(loopback_address(*here).port);
  const auto there = open({}, [&](DatagramIo io) { return gate.put_around(std::move(io)); });
  Subscriber subscriber(*here, {"*"});
  {
    Publisher publisher(*there);
    subscriber.listen_to(publisher.id());
    publisher.serve({{loopback_address(*here)}});
    for (int i = 0; i < 3; ++i) publisher.publish(make_image(100'000));
  }
  gate.open();
  EXPECT_EQ(subscriber.await_sequences(3), first_numbers(3));
}

TEST_P(TransportTest, PacesWhatASmallReceiveBufferCannotHold) {
  const auto there = open({.pace_bytes_per_s = 100'000'000}), here = open({.receive_buffer_bytes = 400'000});
  Publisher publisher(*there);
  publisher.serve({{loopback_address(*here)}});
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(publisher.publish(make_image(5'000'000)), core::SendStatus::sent);
  EXPECT_TRUE(eventually([&] { return publisher.port().bytes_sent() > 5'000'000; }));
  EXPECT_GT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(45));
}

TEST_P(TransportTest, KeepsTheNewestUntilTheyAreTaken) {
  const auto there = open(), here = open();
  const auto reader = here->open_reader({.id = 1,
                                         .type = &test::type_support<Image>(),
                                         .depth = 3,
                                         .listener = nullptr,
                                         .doorbell = {}})
                          .value();
  Publisher publisher(*there);
  reader->accept({{fields<Image>("*")}});
  ASSERT_TRUE(reader->connect({publisher.id(), 0}));
  publisher.serve({{loopback_address(*here)}});
  for (int i = 0; i < 10; ++i) publisher.publish(make_image(10));
  EXPECT_TRUE(eventually([&] { return reader->discarded() == 7; }));
  for (std::uint64_t sequence = 8; sequence <= 10; ++sequence)
    EXPECT_EQ(reader->take()->header().sequence, sequence);
  EXPECT_FALSE(reader->take());
}

TEST_P(TransportTest, ReceivesIntoThePoolThatItSharesWithTheNode) {
  const auto pool = core::BufferPool::make(1'000'000);
  const auto there = open();
  const auto here =
      open_udp_transport({.bind_address = INADDR_LOOPBACK, .backend = GetParam()}, pool).value();
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here)}});
  std::vector<core::SampleHandle> published_here;
  while (core::SampleHandle sample = pool->take(200'000)) published_here.push_back(std::move(sample));
  publisher.publish(make_image(100'000));
  EXPECT_TRUE(eventually([&] { return here->counters().over_limit == 1; }));
  published_here.clear();
  publisher.publish(make_image(100'000));
  EXPECT_EQ(subscriber.await_sequences(1), std::vector<std::uint64_t>{2});
}

TEST_P(TransportTest, DeliversOnlyWhatIsConnectedAndAccepted) {
  const auto there = open(), here = open();
  Subscriber subscriber(*here, {"data"}), other(*here, {"*"});
  Publisher publisher(*there);
  EXPECT_FALSE(subscriber.port().connected(publisher.id()));
  subscriber.listen_to(publisher.id());
  other.listen_to(publisher.id());
  EXPECT_TRUE(subscriber.port().connected(publisher.id()));
  publisher.serve({{loopback_address(*here), "*"}});
  publisher.publish(make_image(10));
  EXPECT_EQ(other.await_sequences(1), first_numbers(1));
  EXPECT_FALSE(subscriber.port().take());

  other.port().disconnect(publisher.id());
  EXPECT_FALSE(other.port().connected(publisher.id()));
  const std::uint64_t unknown = here->counters().unknown;
  publisher.publish(make_image(10));
  EXPECT_TRUE(eventually([&] { return here->counters().unknown > unknown; }));
  EXPECT_EQ(other.await_sequences(1), first_numbers(1));
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
      {.port = port, .bind_address = INADDR_LOOPBACK, .backend = GetParam()}, test::make_pool());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::address_in_use);
  EXPECT_NE(second.error().message.find(std::to_string(port)), std::string::npos) << second.error().message;
}

TEST_P(TransportTest, GivesItsPortBackWhenItCloses) {
  UdpOptions options{.bind_address = INADDR_LOOPBACK, .backend = GetParam()};
  options.port = open()->addresses()[0].port;
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(open_udp_transport(options, test::make_pool()));
}

TEST_P(TransportTest, RefusesTwoWritersWithOneShortId) {
  const auto here = open();
  Subscriber subscriber(*here, {"*"});
  subscriber.listen_to(0x1'0000'0007);
  const Result<void> second = subscriber.port().connect({0x2'0000'0007, 0});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::unavailable);
}

TEST_P(TransportTest, TellsPortsThatItIsGone) {
  auto there = open();
  const auto here = open();
  Publisher publisher(*there);
  publisher.serve({{loopback_address(*here)}});
  Subscriber subscriber(*there, {"*"});
  there.reset();
  EXPECT_EQ(publisher.publish(make_image(10)), core::SendStatus::lost_port);
  EXPECT_FALSE(subscriber.port().take());
}

TEST_P(TransportTest, DeliversEachSampleOnceOrCountsIt) {
  const std::uint64_t seed = sft::test::test_seed();
  SCOPED_TRACE(sft::test::how_to_repeat());
  const auto there = open({.max_datagram_bytes = 1472});
  const auto here = open({.reassembly = {.patience = std::chrono::milliseconds(20)}}, [&](DatagramIo io) {
    io.receiver = std::make_unique<test::FaultyReceiver>(
        std::move(io.receiver), test::Faults{.loss = 0.0005, .repetition = 0.1, .swap = 0.1}, seed);
    return io;
  });
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here)}});
  const auto lost = [&] {
    const auto counters = here->counters();
    return counters.incomplete + counters.over_limit + subscriber.port().discarded();
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

/// Publishes without pause from a thread of its own.
class Flood {
 public:
  Flood(core::Transport& transport, const core::UdpAddress& to, std::size_t bytes) : publisher_(transport) {
    publisher_.serve({{to}});
    thread_ = std::thread([this, bytes] {
      const Image image = make_image(bytes);
      while (!done_) publisher_.publish(image);
    });
  }
  ~Flood() {
    done_ = true;
    thread_.join();
  }
  core::EndpointId id() const { return publisher_.id(); }

 private:
  Publisher publisher_;
  std::atomic<bool> done_{false};
  std::thread thread_;
};

class Untouchable final : public core::ArrivalListener {
 public:
  void arrived() noexcept override {
    EXPECT_FALSE(gone);
    ++calls;
  }
  std::atomic<bool> gone{false};
  std::atomic<int> calls{0};
};

TEST_P(TransportTest, CallsNoListenerAfterItsReaderWent) {
  const auto there = open(), here = open();
  for (const std::size_t bytes : {20U, 100'000U}) {
    Flood flood(*there, loopback_address(*here), bytes);
    for (int i = 0; i < 50; ++i) {
      Untouchable listener;
      auto reader = here->open_reader({.id = 1,
                                       .type = &test::type_support<Image>(),
                                       .depth = 1,
                                       .listener = &listener,
                                       .doorbell = {}})
                        .value();
      reader->accept({{fields<Image>("*")}});
      ASSERT_TRUE(reader->connect({flood.id(), 0}));
      ASSERT_TRUE(eventually([&] { return listener.calls > 0; }));
      reader.reset();
      listener.gone = true;
    }
  }
}

class ReaderDestroying final : public core::ArrivalListener {
 public:
  void arrived() noexcept override {
    reader.reset();
    done = true;
  }
  std::unique_ptr<core::ReaderPort> reader;
  std::atomic<bool> done{false};
};

TEST_P(TransportTest, LetsAListenerDestroyItsReader) {
  const auto there = open(), here = open();
  for (int i = 0; i < 20; ++i) {
    ReaderDestroying listener;
    listener.reader = here->open_reader({.id = 1,
                                         .type = &test::type_support<Image>(),
                                         .depth = 1,
                                         .listener = &listener,
                                         .doorbell = {}})
                          .value();
    listener.reader->accept({{fields<Image>("*")}});
    Publisher publisher(*there);
    ASSERT_TRUE(listener.reader->connect({publisher.id(), 0}));
    publisher.serve({{loopback_address(*here)}});
    publisher.publish(make_image(10));
    ASSERT_TRUE(eventually([&] { return listener.done.load(); }));
  }
}

TEST_P(TransportTest, ClosesWhileDatagramsCome) {
  const auto there = open();
  for (int i = 0; i < 20; ++i) {
    auto here = open();
    Flood flood(*there, loopback_address(*here), 50'000);
    Subscriber subscriber(*here, {"*"}, 1);
    subscriber.listen_to(flood.id());
    EXPECT_GE(subscriber.await(1).size(), 1U);
    here.reset();
  }
}

TEST_P(TransportTest, ClosesWhileItSends) {
  const auto here = open();
  for (int i = 0; i < 20; ++i) {
    auto there = open();
    Publisher publisher(*there);
    publisher.serve({{loopback_address(*here)}});
    for (int k = 0; k < 4; ++k) publisher.publish(make_image(4'000'000));
    there.reset();
  }
}

}  // namespace
}  // namespace sft::udp
