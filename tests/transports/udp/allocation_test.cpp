// Counts the allocations by operator new of the process while samples are sent. Buffers and queues grow until
// they suffice for all samples in use at the same time. After that no sample allocates.
#include <gtest/gtest.h>
#include <netinet/in.h>

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>

#include "tests/support/parse_datagram.h"
#include "tests/support/process_allocations.h"
#include "tests/transports/udp/endpoints.h"
#include "tests/transports/udp/faulty_io.h"
#include "udp_transport/udp_transport.h"

namespace sft::udp {
namespace {

using test::fields;
using test::Image;

class Counting final : public core::ArrivalListener {
 public:
  void arrived() noexcept override {
    while (reader->take()) ++samples;
  }
  core::NetworkReader* reader = nullptr;
  std::atomic<std::size_t> samples{0};
};

/// Drops all acks to one transport until the gate is opened.
class AckGate {
 public:
  DatagramIo put_around(DatagramIo io) {
    io.sender = std::make_unique<Gated>(std::move(io.sender), *this);
    return io;
  }
  void open() { open_ = true; }
  /// Returns an ordinal. The sending thread has processed the acks of all samples before it.
  std::uint64_t acknowledged() const { return acknowledged_; }

 private:
  class Gated final : public test::PassingSender {
   public:
    Gated(std::unique_ptr<DatagramSender> inner, AckGate& gate)
        : PassingSender(std::move(inner)), gate_(gate) {}

    Answer take_answer(std::span<std::byte> to) noexcept override {
      for (;;) {
        const Answer answer = PassingSender::take_answer(to);
        const std::optional<Ack> ack = parse_as<Ack>(to.first(answer.bytes));
        if (ack && !gate_.open_) continue;
        if (ack) heard_ = ack->next;
        return answer;
      }
    }
    void await(std::chrono::steady_clock::time_point deadline) noexcept override {
      gate_.acknowledged_ = heard_;
      PassingSender::await(deadline);
    }

   private:
    AckGate& gate_;
    std::uint64_t heard_ = 0;
  };

  std::atomic<bool> open_{false};
  std::atomic<std::uint64_t> acknowledged_{0};
};

struct Case {
  std::size_t bytes;
  bool reliable;
};

/// A writer and its reader in the same process.
class Stream {
 public:
  Stream(Backend backend, const Case& of) : image_(test::make_image(of.bytes)) {
    transport_ = open_udp_transport({.bind_address = INADDR_LOOPBACK, .backend = backend}, test::make_pool(),
                                    [&](DatagramIo io) { return acks_.put_around(std::move(io)); })
                     .value();
    reader_ = transport_
                  ->open_reader({.id = 1,
                                 .type = &test::type_support<Image>(),
                                 .depth = 8,
                                 .listener = &listener_,
                                 .doorbell = {}})
                  .value();
    listener_.reader = reader_.get();
    reader_->accept({{.wanted = {fields<Image>("*")}}, {.wanted = {fields<Image>("data")}}});
    writer_ = transport_->open_writer({7, &test::type_support<Image>()}).value();
    EXPECT_TRUE(reader_->connect({.writer = 7, .reliable = of.reliable}));
    core::Route route{1, test::loopback_address(*transport_), fields<Image>("data")};
    route.reliable = of.reliable;
    writer_->set_routes({route});
  }

  void send() {
    const core::SampleHandle sample = pool_->take(test::sample_bytes(image_, all_));
    test::fill(*sample, image_, all_, 7, ++sent_);
    writer_->send(sample);
  }
  /// Sends samples one by one: each after the one before has arrived.
  void exchange(int samples) {
    for (int i = 0; i < samples; ++i) {
      const std::size_t before = came();
      send();
      const auto deadline =
          // A best-effort sample may be lost, so the wait is limited.
          std::chrono::steady_clock::now() + std::chrono::seconds(2);
      while (came() == before && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
    }
  }
  std::size_t came() const { return listener_.samples; }

  /// Lets acks pass from now on. Returns true when the writer keeps no more samples for repair.
  bool acknowledge_all() {
    acks_.open();
    return test::eventually([&] { return acks_.acknowledged() > sent_; });
  }

 private:
  const Image image_;
  const FieldMask all_ = fields<Image>("*");
  const std::shared_ptr<core::BufferPool> pool_ = test::make_pool();
  AckGate acks_;
  Counting listener_;
  std::uint64_t sent_ = 0;
  std::unique_ptr<core::Network> transport_;
  std::unique_ptr<core::NetworkReader> reader_;
  std::unique_ptr<core::NetworkWriter> writer_;
};

class AllocationTest : public testing::TestWithParam<Case> {};

INSTANTIATE_TEST_SUITE_P(Sizes, AllocationTest,
                         testing::Values(Case{64, false}, Case{10'000, false}, Case{1'000'000, false},
                                         Case{64, true}, Case{10'000, true}, Case{1'000'000, true}),
                         [](const auto& param) {
                           return (param.param.reliable ? "Reliable" : "BestEffort") +
                                  std::to_string(param.param.bytes);
                         });

TEST_P(AllocationTest, HappensForNoSampleOnceBuffersHaveGrown) {
  for (const Backend backend : {Backend::automatic, Backend::sockets}) {
    Stream stream(backend, GetParam());
    constexpr int bursts = 5, at_once = 12, one_by_one = 10, measured = 200;
    // The sending thread handles an ack only when it gets a processor. Until then the writer keeps samples
    // for repair. So no ack passes until as many samples are kept as will be sent later. After these samples
    // were acknowledged, the writer never keeps more samples at the same time, and needs no more memory.
    stream.exchange(GetParam().reliable ? bursts * (at_once + one_by_one) + measured : 50);
    ASSERT_TRUE(!GetParam().reliable || stream.acknowledge_all());
    // A thread that has sent or received a sample may be delayed before it gives back the memory for the
    // sample. Only few samples are delayed in this way at the same time. The bursts allocate enough memory
    // for them in advance.
    for (int burst = 0; burst < bursts; ++burst) {
      for (int i = 0; i < at_once; ++i) stream.send();
      stream.exchange(one_by_one);
    }
    const std::size_t came = stream.came();
    sft::test::note_allocations();
    const std::uint64_t before = sft::test::process_allocations();
    stream.exchange(measured);
    const std::uint64_t allocations = sft::test::process_allocations() - before;
    // If a large reliable sample arrives slowly, the reader may request parts of the sample. Each request
    // allocates a list of gaps.
    const bool may_be_asked_for = GetParam().reliable && GetParam().bytes > 100'000;
    EXPECT_LE(allocations, may_be_asked_for ? 19U : 0U);
    if (allocations != 0) sft::test::print_allocations();
    EXPECT_GE(stream.came() - came, GetParam().reliable ? 200U : 150U);
  }
}

/// Sending a large sample under many masks may take longer than the pause between two runs of the agent.
TEST(AgentAllocations, AreNoneWhileWritersAreOnlyLookedAfter) {
  const auto transport = open_udp_transport({.bind_address = INADDR_LOOPBACK}, test::make_pool()).value();
  const auto writer = transport->open_writer({7, &test::type_support<Image>()}).value();
  writer->set_routes({{1, test::loopback_address(*transport), fields<Image>("data")}});
  auto now = std::chrono::steady_clock::now();
  const auto look_for_a_minute = [&] {
    for (int i = 0; i < 1200; ++i) transport->poll(now += std::chrono::milliseconds(50));
  };
  look_for_a_minute();
  const std::uint64_t before = sft::test::process_allocations();
  look_for_a_minute();
  EXPECT_EQ(sft::test::process_allocations() - before, 0U);
}

}  // namespace
}  // namespace sft::udp
