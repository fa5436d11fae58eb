// Counts every operator new of the process while samples travel: buffers and queues grow to what is needed at
// a time, and then no sample costs one.
#include <gtest/gtest.h>
#include <netinet/in.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "tests/support/process_allocations.h"
#include "tests/transports/udp/endpoints.h"
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

struct Case {
  std::size_t bytes;
  bool reliable;
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
    const auto transport =
        open_udp_transport({.bind_address = INADDR_LOOPBACK, .backend = backend}, test::make_pool()).value();
    Counting listener;
    const auto reader = transport
                            ->open_reader({.id = 1,
                                           .type = &test::type_support<Image>(),
                                           .depth = 8,
                                           .listener = &listener,
                                           .doorbell = {}})
                            .value();
    listener.reader = reader.get();
    reader->accept({{.wanted = {fields<Image>("*")}}, {.wanted = {fields<Image>("data")}}});
    const auto writer = transport->open_writer({7, &test::type_support<Image>()}).value();
    ASSERT_TRUE(reader->connect({.writer = 7, .reliable = GetParam().reliable}));
    core::Route route{1, test::loopback_address(*transport), fields<Image>("data")};
    route.reliable = GetParam().reliable;
    writer->set_routes({route});

    const std::shared_ptr<core::BufferPool> pool = test::make_pool();
    const Image image = test::make_image(GetParam().bytes);
    const FieldMask all = fields<Image>("*");
    // The memory that is kept for repair grows to the amount that the other end acknowledges at a time.
    const std::uint64_t warm_up = GetParam().reliable && GetParam().bytes < 100'000 ? 2'500 : 50;
    const auto send = [&](std::uint64_t sequence) {
      const core::SampleHandle sample = pool->take(test::sample_bytes(image, all));
      test::fill(*sample, image, all, 7, sequence);
      writer->send(sample);
    };
    const auto exchange = [&](std::uint64_t sequence) {
      const std::size_t before = listener.samples;
      send(sequence);
      const auto deadline =
          std::chrono::steady_clock::now() + std::chrono::seconds(2);  // a lost one may be lost
      while (listener.samples == before && std::chrono::steady_clock::now() < deadline)
        std::this_thread::yield();
    };
    std::uint64_t sequence = 0;
    while (sequence < warm_up) exchange(++sequence);
    // A thread that has sent or received a sample may be kept from giving back what it took for that. More
    // than a few are never out at once here, so they are taken now.
    for (int burst = 0; burst < 5; ++burst) {
      for (int i = 0; i < 12; ++i) send(++sequence);
      for (int i = 0; i < 10; ++i) exchange(++sequence);
    }
    const std::size_t came = listener.samples;
    sft::test::note_allocations();
    const std::uint64_t before = sft::test::process_allocations();
    for (int i = 0; i < 200; ++i) exchange(++sequence);
    const std::uint64_t allocations = sft::test::process_allocations() - before;
    // A large sample that comes slowly, and is sent reliably, may be asked for again: each request has a list
    // of gaps of its own.
    const bool may_be_asked_for = GetParam().reliable && GetParam().bytes > 100'000;
    EXPECT_LE(allocations, may_be_asked_for ? 19U : 0U);
    if (allocations != 0) sft::test::print_allocations();
    EXPECT_GE(listener.samples - came, GetParam().reliable ? 200U : 150U);
  }
}

/// A large sample to many masks may take longer than the agent sleeps.
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
