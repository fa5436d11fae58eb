// Tests how a publisher changes the paths that serve its readers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <future>
#include <optional>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <set>
#include <vector>

#include "core/publish/publisher_core.h"
#include "sft/detail/encode.h"
#include "sft/detail/project.h"
#include "tests/unit/core/publish/port_logs.h"
#include "tests/unit/core/seam/idle_ports.h"

namespace sft::core {
namespace {

using namespace detail;

using namespace std::chrono_literals;
using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

/// A port whose send() blocks until the test sets `go_on`.
class SlowPort final : public IdleNetworkWriter {
 public:
  void set_routes(std::vector<Route>) override { ++routes_set; }

  std::promise<void> sending;
  std::promise<void> go_on;
  std::atomic<int> routes_set{0};

 private:
  SendStatus send_begun(const SampleHandle&, Reach) noexcept override {
    sending.set_value();
    go_on.get_future().wait();
    return SendStatus::sent;
  }
};

class PublisherServingTest : public ::testing::Test {
 protected:
  Serving to_one(const FieldMask& mask) const {
    Serving serving;
    serving.network = {{2, UdpAddress{0x7f000001, 5000}, type.closed(mask)}};
    return serving;
  }

  std::vector<std::byte> payload() const { return payload_of(cloud); }
  std::vector<std::byte> payload_of(const PointCloud2& message) const {
    const FieldMask all = type.full();
    std::vector<std::byte> bytes(encapsulation_bytes + encoded_size(type.type(), &message, all).bytes);
    std::memcpy(bytes.data(), encapsulation_cdr_le.data(), encapsulation_bytes);
    std::vector<std::uint32_t> index(type.index_slots());
    encode(type.type(), &message, all, std::span(bytes).subspan(encapsulation_bytes), index);
    return bytes;
  }

  /// Expects that serve() with a greater mask waits while the port blocks the thread that runs `publish`.
  /// The port blocks until the test allows it to continue.
  template <class Publish>
  void expect_waited_for(Publish publish) {
    publisher.serve(to_one(FieldMask(F::height)), nullptr);
    auto publishing = std::async(std::launch::async, publish);
    port->sending.get_future().wait();
    auto serving = std::async(std::launch::async, [&] { publisher.serve(to_one(type.full()), nullptr); });
    EXPECT_EQ(serving.wait_for(50ms), std::future_status::timeout);
    EXPECT_EQ(port->routes_set, 1);
    port->go_on.set_value();
    serving.wait();
    publishing.wait();
    EXPECT_EQ(port->routes_set, 2);
  }

  const TypeSupport type{TypeTable<PointCloud2>::type};
  const PointCloud2 cloud{};
  const std::shared_ptr<SlowPort> port = std::make_shared<SlowPort>();
  PublisherCore publisher{{1, "points", &type, 1 << 16}, BufferPool::make(1 << 20), port};
};

TEST_F(PublisherServingTest, RoutesThatAskForMoreWaitForAPublishThatBeganBefore) {
  expect_waited_for([&] { publisher.publish(&cloud); });
}

TEST_F(PublisherServingTest, RoutesThatAskForMoreWaitForALoanBeingPublished) {
  expect_waited_for([&] {
    Result<SampleHandle> loan = publisher.loan(&cloud, {}, ReservedMemory::zeroed);
    ASSERT_TRUE(loan);
    publisher.commit(std::move(*loan), false);
  });
}

TEST_F(PublisherServingTest, RoutesThatAskForMoreWaitForAPayloadBeingPublished) {
  expect_waited_for([&] { EXPECT_TRUE(publisher.publish_cdr(payload())); });
}

TEST_F(PublisherServingTest, APayloadIsWalkedOnlyIfThereIsAReader) {
  std::vector<std::byte> cut = payload();
  cut.resize(cut.size() / 2);
  EXPECT_EQ(publisher.publish_cdr(cut).value(), PublishStatus::ok);
  EXPECT_EQ(publisher.status().published, 1U);
  publisher.serve(to_one(type.full()), nullptr);
  EXPECT_EQ(publisher.publish_cdr(cut).error().code, Errc::malformed);
  EXPECT_EQ(publisher.status().published, 1U);
}

TEST_F(PublisherServingTest, AMessageThatIsTooLargeOrHasAFaultIsInvalidWhoeverListens) {
  std::vector<std::string> reported;
  PublisherCore reporting{{.id = 1,
                           .topic = "points",
                           .type = &type,
                           .max_sample_bytes = 1 << 16,
                           .refused = [&](const std::string& why) { reported.push_back(why); }},
                          BufferPool::make(1 << 20),
                          std::make_shared<IdleNetworkWriter>()};
  PointCloud2 large;
  large.data.resize(1 << 16);
  PointCloud2 faulty;
  faulty.header.frame_id = std::string("a\0b", 3);
  const auto expect_refused = [&] {
    for (const PointCloud2* one : {&large, &faulty}) {
      EXPECT_EQ(reporting.publish(one), PublishStatus::invalid);
      const std::vector<PointCloud2> two{cloud, *one};
      const PublishedSpan span = reporting.publish(two.data(), two.size(), sizeof(PointCloud2));
      EXPECT_EQ(span.status, PublishStatus::invalid);
      EXPECT_EQ(span.published, 1U);
    }
  };
  expect_refused();  // there is no reader
  reporting.serve(to_one(FieldMask(F::height)), nullptr);
  expect_refused();
  reporting.serve(to_one(type.full()), nullptr);
  expect_refused();
  ASSERT_FALSE(reported.empty());
  EXPECT_LT(reported.size(), 12U) << "a flood has few reports";
  EXPECT_NE(reported.front().find("topic 'points': "), std::string::npos) << reported.front();
  EXPECT_NE(reported.front().find("raise PublisherOptions::max_sample_bytes"), std::string::npos)
      << reported.front();
}

TEST_F(PublisherServingTest, APayloadThatIsTooLargeIsAnErrorWhoeverListens) {
  PointCloud2 large;
  large.data.resize(1 << 16);
  EXPECT_EQ(publisher.publish_cdr(payload_of(large)).error().code, Errc::limit_exceeded);
}

TEST_F(PublisherServingTest, TheEncapsulationOfAnUnreadPayloadIsCheckedToo) {
  EXPECT_FALSE(publisher.publish_cdr({}));
}

TEST_F(PublisherServingTest, OnceClosedItTellsTheProgramOfNoReaders) {
  int notified = 0;
  PublisherCore::Spec spec{1, "points", &type, 1 << 16};
  spec.on_readers_changed = [&](const PublisherStatus&) { ++notified; };
  PublisherCore telling(spec, BufferPool::make(1 << 20), port);
  telling.serve(to_one(type.full()), nullptr);
  EXPECT_EQ(notified, 1);
  telling.close();
  telling.serve({}, nullptr);
  EXPECT_EQ(notified, 1);
}

using PublisherServingDeathTest = PublisherServingTest;

TEST_F(PublisherServingDeathTest, ASecondThreadThatPublishesMeanwhileIsStoppedWithASentence) {
  publisher.serve(to_one(type.full()), nullptr);
  Result<SampleHandle> loan = publisher.loan(&cloud, {}, ReservedMemory::zeroed);
  auto publishing = std::async(std::launch::async, [&] { publisher.publish(&cloud); });
  port->sending.get_future().wait();
  const char* const why = "sft: topic 'points': two threads publish with one publisher at the same time: ";
  EXPECT_DEATH(publisher.publish(&cloud), why);
  EXPECT_DEATH(publisher.publish(&cloud, 1, sizeof cloud), why);
  EXPECT_DEATH((void)publisher.publish_cdr(payload()), why);
  EXPECT_DEATH((void)publisher.loan(&cloud, {}, ReservedMemory::zeroed), why);
  EXPECT_DEATH((void)publisher.loan_cdr(100), why);
  EXPECT_DEATH(publisher.commit(*loan, true), why);
  EXPECT_DEATH((void)publisher.commit_cdr(*loan), why);
  port->go_on.set_value();
}

/// A publisher that publishes a sample before and after each change of the routes of one of its ports. The
/// fixture records the samples that one of the readers gets through either port.
class ChangeOverTest : public ::testing::Test {
 protected:
  static constexpr EndpointId reader = 2;

  /// A port that delivers samples to the reader while it has a route to the reader.
  template <class Idle>
  class Port : public Idle {
   public:
    explicit Port(ChangeOverTest& test) : test_(test) {}
    void set_routes(std::vector<Route> routes) override {
      test_.publish();
      const auto is_for_reader = [](const Route& r) { return r.reader == reader && !r.fallback; };
      EXPECT_LE(std::ranges::count(routes, reader, &Route::reader), 1);
      serves_ = std::ranges::any_of(routes, is_for_reader);
      test_.publish();
    }

   protected:
    SendStatus pass_on(const SampleHandle& sample) {
      if (serves_) test_.came_.insert(sample->sequence);
      return SendStatus::sent;
    }
    ChangeOverTest& test_;

   private:
    bool serves_ = false;
  };
  class Network final : public Port<IdleNetworkWriter> {
    using Port::Port;
    SendStatus send_begun(const SampleHandle& sample, Reach) noexcept override { return pass_on(sample); }
  };
  class Memory final : public Port<IdleLendingWriter> {
   public:
    using Port::Port;
    SampleHandle loan(std::size_t bytes) noexcept override { return test_.pool_->take(bytes); }
    SendStatus send(const SampleHandle& sample) noexcept override { return pass_on(sample); }
  };

  Route to(EndpointId id) const { return {id, UdpAddress{0x7f000001, 5000}, type_.full()}; }
  void publish() {
    if (is_open_) publisher_.publish(&cloud_);
  }
  /// Serves the readers `here` in memory, and the readers `elsewhere` over the network.
  void serve(std::vector<EndpointId> here, std::vector<EndpointId> elsewhere) {
    Serving serving;
    for (const EndpointId id : here) {
      serving.memory.push_back(to(id));
      serving.fallback.push_back(to(id));
      serving.fallback.back().fallback = true;
    }
    for (const EndpointId id : elsewhere) serving.network.push_back(to(id));
    publisher_.serve(serving, memory_);
    is_open_ = true;
    publish();
  }

  const TypeSupport type_{TypeTable<PointCloud2>::type};
  const PointCloud2 cloud_{};
  std::set<std::uint64_t> came_;
  bool is_open_ = false;  ///< true while the reader is served
  const std::shared_ptr<BufferPool> pool_ = BufferPool::make(1 << 20);
  const std::shared_ptr<Memory> memory_ = std::make_shared<Memory>(*this);
  PublisherCore publisher_{
      {1, "points", &type_, 1 << 16}, BufferPool::make(1 << 20), std::make_shared<Network>(*this)};
};

TEST_F(ChangeOverTest, NoSampleFallsBetweenTheTwoPortsOfAReader) {
  serve({}, {reader});
  serve({reader}, {});
  serve({}, {reader});
  serve({reader, 3}, {4});
  serve({3}, {reader, 4});
  serve({reader, 4}, {3});
  serve({3}, {4, reader});
  EXPECT_GT(came_.size(), 20U);
  EXPECT_EQ(came_.size(), publisher_.status().published);
}

/// A port that records the destinations to which it has to send the history.
class HistoryPort final : public IdleNetworkWriter {
 public:
  void send_history(const Route& to, std::vector<SampleHandle> samples) override {
    given.emplace_back(std::get<UdpAddress>(to.destination).port, samples.size());
  }

  /// The UDP port numbers of the destinations, each with the number of retained samples that were sent to
  /// it.
  std::vector<std::pair<int, std::size_t>> given;
};

TEST_F(PublisherServingTest, ALateReaderIsGivenTheHistoryOnceAndAgainWhereItHasMoved) {
  PublisherCore::Spec spec{1, "points", &type, 1 << 16};
  spec.qos = {.durability = transient_local, .history_depth = 3};
  const auto network = std::make_shared<HistoryPort>();
  PublisherCore durable(std::move(spec), BufferPool::make(1 << 20), network);
  for (int i = 0; i < 4; ++i) durable.publish(&cloud);
  const auto serve_at = [&](std::uint16_t socket, std::uint32_t history) {
    Serving serving = to_one(type.full());
    serving.network[0].destination = UdpAddress{0x7f000001, socket};
    serving.network[0].history = history;
    durable.serve(serving, nullptr);
  };
  using Given = decltype(network->given);
  serve_at(5000, 2);
  serve_at(5000, 2);
  EXPECT_EQ(network->given, (Given{{5000, 2}}));
  serve_at(6000, 2);
  EXPECT_EQ(network->given, (Given{{5000, 2}, {6000, 2}}));
  serve_at(7000, 0);
  serve_at(7000, 2);
  EXPECT_EQ(network->given, (Given{{5000, 2}, {6000, 2}, {7000, 2}}));
}

/// A port that runs a function of the test while routes change. The function may publish.
class InterruptedPort final : public IdleNetworkWriter {
 public:
  void set_routes(std::vector<Route>) override {
    if (meanwhile) meanwhile();
  }

  std::function<void()> meanwhile;
};

/// A port that counts the samples that are sent.
class CountingMemory final : public IdleLendingWriter {
 public:
  SampleHandle loan(std::size_t bytes) noexcept override { return memory_->take(bytes); }
  SendStatus send(const SampleHandle&) noexcept override { return ++sent, SendStatus::sent; }

  int sent = 0;

 private:
  const std::shared_ptr<BufferPool> memory_ = BufferPool::make(1 << 20);
};

TEST_F(PublisherServingTest, AReaderThatChangesOverToSharedMemoryIsSentASampleThereThatIsPublishedMeanwhile) {
  const auto network = std::make_shared<InterruptedPort>();
  const auto in_memory = std::make_shared<CountingMemory>();
  PublisherCore changing({1, "points", &type, 1 << 16}, BufferPool::make(1 << 20), network);
  changing.serve(to_one(type.full()), nullptr);
  network->meanwhile = [&] { changing.publish(&cloud); };
  Serving serving;
  serving.memory_port = true;
  serving.memory = {{.reader = 2, .destination = DoorbellAddress{}, .selection = type.full()}};
  changing.serve(serving, in_memory);
  EXPECT_EQ(in_memory->sent, 1);
}

class LateInMemoryTest : public PublisherServingTest {
 protected:
  PublisherCore::Spec retaining() const {
    PublisherCore::Spec spec{1, "points", &type, 1 << 16};
    spec.qos.durability = Durability::transient_local;
    spec.qos.history_depth = 3;
    return spec;
  }
  Serving to_late_reader() const {
    Serving serving;
    serving.memory = {
        {.reader = 2, .destination = DoorbellAddress{}, .selection = type.full(), .history = 2}};
    return serving;
  }
  /// Returns the sequences of the samples that the reader got. Expects that these samples lie in the port's
  /// memory.
  std::vector<std::uint64_t> given() const {
    std::vector<std::uint64_t> sequences;
    for (const SampleHandle& sample : memory->given.value()) {
      EXPECT_TRUE(memory->owns(*sample));
      sequences.push_back(sample->sequence);
    }
    return sequences;
  }
  const std::shared_ptr<test::MemoryLog> memory = std::make_shared<test::MemoryLog>();
};

TEST_F(LateInMemoryTest, AReaderIsGivenWhatWasPublishedBeforeThereWasSharedMemory) {
  PublisherCore durable(retaining(), BufferPool::make(1 << 20), nullptr);
  for (int i = 0; i < 4; ++i) durable.publish(&cloud);
  durable.serve(to_late_reader(), memory);
  EXPECT_EQ(given(), (std::vector<std::uint64_t>{3, 4}));
  durable.give_history();
  EXPECT_EQ(given().size(), 2U) << "once";
}

TEST_F(LateInMemoryTest, AReaderFromWhichSomethingIsHeldBackMeanwhileIsGivenThatToo) {
  PublisherCore durable(retaining(), BufferPool::make(1 << 20), nullptr);
  durable.publish(&cloud);
  memory->interruptions = 30;
  durable.serve(to_late_reader(), memory);
  EXPECT_FALSE(memory->given) << "the agent has other things to do";
  durable.publish(&cloud);
  durable.give_history();
  EXPECT_EQ(given(), (std::vector<std::uint64_t>{1, 2}));
}

/// Shared memory whose send() waits for readers for the duration `waits`. It has no chunk for the first
/// `refusals` loans.
class FullMemoryPort final : public IdleLendingWriter {
 public:
  SampleHandle loan(std::size_t bytes) noexcept override {
    if (refusals == 0) return memory_->take(bytes);
    --refusals;
    return {};
  }
  SendStatus send(const SampleHandle&) noexcept override {
    timeout_ -= waits;
    return SendStatus::sent;
  }
  void set_timeout(std::chrono::nanoseconds at_most) noexcept override { timeout_ = at_most; }
  std::chrono::nanoseconds time_left() const noexcept override { return timeout_; }

  std::chrono::nanoseconds waits{0};
  int refusals = 0;

 private:
  const std::shared_ptr<BufferPool> memory_ = BufferPool::make(1 << 20);
  std::chrono::nanoseconds timeout_{0};
};

class WaitingPort final : public IdleNetworkWriter {
 public:
  void set_timeout(std::chrono::nanoseconds at_most) noexcept override { timeout = at_most; }
  std::chrono::nanoseconds timeout{0};
};

class WaitingPublisherTest : public PublisherServingTest {
 protected:
  PublisherCore::Spec waiting() const {
    PublisherCore::Spec spec{1, "points", &type, 1 << 16};
    spec.max_blocking = std::chrono::milliseconds(100);
    return spec;
  }
  Route local(bool reliable) const {
    Route route{.reader = 2, .destination = DoorbellAddress{}, .selection = type.full()};
    route.reliable = reliable;
    return route;
  }
  const std::shared_ptr<FullMemoryPort> memory = std::make_shared<FullMemoryPort>();
};

TEST_F(WaitingPublisherTest, WaitsForReadersByBothPathsNoLongerThanForThoseByOne) {
  const auto network = std::make_shared<WaitingPort>();
  PublisherCore core(waiting(), BufferPool::make(1 << 20), network);
  Serving serving;
  serving.memory = {local(true)};
  serving.network = {Route{3, UdpAddress{}, type.full()}};
  core.serve(serving, memory);
  memory->waits = std::chrono::milliseconds(30);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(core.publish(&cloud), PublishStatus::ok);
    EXPECT_EQ(network->timeout, std::chrono::milliseconds(70)) << "for each sample anew";
  }
}

TEST_F(WaitingPublisherTest, WaitsForAChunkWhereAReliableReaderCanBeSentNothingByUdp) {
  PublisherCore core(waiting(), BufferPool::make(1 << 20), nullptr);
  Serving serving;
  serving.memory = {local(true)};
  core.serve(serving, memory);
  memory->refusals = 3;
  EXPECT_EQ(core.publish(&cloud), PublishStatus::ok);
  EXPECT_EQ(memory->refusals, 0);
}

TEST_F(WaitingPublisherTest, WaitsTheShorterForReadersTheLongerItHasWaitedForAChunk) {
  const auto network = std::make_shared<WaitingPort>();
  PublisherCore core(waiting(), BufferPool::make(1 << 20), network);
  Serving serving;
  serving.memory = {local(true)};
  serving.network = {Route{3, UdpAddress{}, type.full()}};
  core.serve(serving, memory);
  memory->refusals = 3;
  core.publish(&cloud);
  EXPECT_EQ(memory->refusals, 0);
  EXPECT_LE(network->timeout, std::chrono::milliseconds(97)) << "it looks once in a millisecond";
}

TEST_F(WaitingPublisherTest, WaitsForNoChunkWhereAReliableReaderHasAFallbackRoute) {
  PublisherCore core(waiting(), BufferPool::make(1 << 20), std::make_shared<WaitingPort>());
  Serving serving;
  serving.memory = {local(true)};
  serving.fallback = {Route{2, UdpAddress{}, type.full()}};
  serving.fallback[0].fallback = true;
  core.serve(serving, memory);
  memory->refusals = 3;
  EXPECT_EQ(core.publish(&cloud), PublishStatus::ok);
  EXPECT_EQ(memory->refusals, 2);
}

TEST_F(WaitingPublisherTest, WaitsForNoChunkOfBestEffortReaders) {
  PublisherCore core(waiting(), BufferPool::make(1 << 20), nullptr);
  Serving serving;
  serving.memory = {local(false)};
  core.serve(serving, memory);
  memory->refusals = 3;
  EXPECT_EQ(core.publish(&cloud), PublishStatus::no_memory);
  EXPECT_EQ(memory->refusals, 2);
}

}  // namespace
}  // namespace sft::core
