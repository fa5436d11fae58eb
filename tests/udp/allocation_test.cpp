// Counts every operator new of the process while samples travel: buffers and queues grow to what is needed at
// a time, and then no sample costs one.
#include <gtest/gtest.h>
#include <netinet/in.h>

#include <atomic>
#include <memory>
#include <thread>

#include "endpoints.h"
#include "tests/support/process_allocations.h"
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
  core::ReaderPort* reader = nullptr;
  std::atomic<std::size_t> samples{0};
};

class AllocationTest : public testing::TestWithParam<std::size_t> {};

INSTANTIATE_TEST_SUITE_P(Sizes, AllocationTest, testing::Values(64, 10'000, 1'000'000));

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
    reader->accept({{fields<Image>("*")}, {fields<Image>("data")}});
    const auto writer = transport->open_writer({7, &test::type_support<Image>()}).value();
    ASSERT_TRUE(reader->connect({7, 0}));
    writer->set_routes({{1, test::loopback_address(*transport), fields<Image>("data")}});

    const std::shared_ptr<core::BufferPool> pool = test::make_pool();
    const Image image = test::make_image(GetParam());
    const FieldMask all = fields<Image>("*");
    const auto exchange = [&](std::uint64_t sequence) {
      const std::size_t before = listener.samples;
      const core::SampleHandle sample = pool->take(test::sample_bytes(image, all));
      test::fill(*sample, image, all, 7, sequence);
      writer->send(sample);
      const auto deadline =
          std::chrono::steady_clock::now() + std::chrono::seconds(2);  // a lost one may be lost
      while (listener.samples == before && std::chrono::steady_clock::now() < deadline)
        std::this_thread::yield();
    };
    for (std::uint64_t sequence = 1; sequence <= 50; ++sequence) exchange(sequence);
    const std::uint64_t before = sft::test::process_allocations();
    for (std::uint64_t sequence = 51; sequence <= 250; ++sequence) exchange(sequence);
    EXPECT_LT(sft::test::process_allocations() - before,
              20U);  // a thread may fall further behind than it did before
    EXPECT_GT(listener.samples, 200U);
  }
}

}  // namespace
}  // namespace sft::udp
