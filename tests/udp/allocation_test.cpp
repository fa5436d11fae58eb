// Counts every operator new of the process while samples travel: buffers and queues grow to what is needed at
// a time, and then no sample costs one.
#include <gtest/gtest.h>
#include <netinet/in.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <new>
#include <thread>

#include "endpoints.h"
#include "udp_transport/udp_transport.h"

namespace {
std::atomic<std::size_t> allocations{0};

void* allocate(std::size_t bytes, std::size_t alignment = alignof(std::max_align_t)) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  void* memory = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
}  // namespace

void* operator new(std::size_t bytes) { return allocate(bytes); }
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept { return allocate(bytes); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return allocate(bytes, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t bytes, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocate(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

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
    const std::size_t before = allocations;
    for (std::uint64_t sequence = 51; sequence <= 250; ++sequence) exchange(sequence);
    EXPECT_LT(allocations - before, 20U);  // a thread may fall further behind than it did before
    EXPECT_GT(listener.samples, 200U);
  }
}

}  // namespace
}  // namespace sft::udp
