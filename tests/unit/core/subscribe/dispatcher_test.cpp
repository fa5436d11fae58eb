// Callbacks on the receiving thread and on the dispatcher.
#include "core/subscribe/dispatcher.h"

#include <gtest/gtest.h>

#include <atomic>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <thread>

#include "core/seam/buffer_pool.h"
#include "tests/support/eventually.h"
#include "tests/unit/core/seam/queue_port.h"

namespace sft::core {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;

TEST(DispatcherTest, EverySampleIsCalledBackForOnceWhileCallbacksMoveBetweenThreads) {
  constexpr std::uint64_t samples = 5000;
  const TypeSupport type{TypeTable<PointCloud2>::type};
  const auto bells = DoorbellPage::create();
  const auto pool = BufferPool::make(64 << 20);
  const auto port = std::make_shared<SharedNetworkQueue>();
  std::atomic<std::uint64_t> called{0};
  std::atomic<int> inside{0}, disorder{0}, by_dispatcher{0};
  Dispatcher dispatcher(bells->at(0), "test");
  const auto call_back = [&](untyped::Sample&& sample) {
    disorder += inside++ == 0 && sample.info().sequence == called + 1 ? 0 : 1;
    by_dispatcher += dispatcher.is_current_thread() ? 1 : 0;
    const auto slow_until = std::chrono::steady_clock::now() + std::chrono::microseconds(300);
    while (sample.info().sequence % 250 == 0 && std::chrono::steady_clock::now() < slow_until) {
    }
    --inside;
    ++called;
  };
  const auto subscriber =
      std::make_shared<SubscriberCore>(SubscriberCore::Spec{.topic = "points",
                                                            .type = &type,
                                                            .feeds = {{.id = 1, .selection = type.full()}},
                                                            .options = {},
                                                            .callback = call_back},
                                       bells->at(0), nullptr);
  subscriber->ports().set_network(port);
  const auto receive = [&](std::uint64_t sequence) {
    SampleHandle sample = pool->take(256);
    sample->writer = 9;
    sample->sequence = sequence;
    port->put(std::move(sample));
    subscriber->arrived();
  };
  // Before the dispatcher starts, because the dispatcher might handle all samples if it got the first one.
  receive(1);
  ASSERT_TRUE(dispatcher.start());
  dispatcher.add(subscriber);
  std::thread receiver([&] {
    for (std::uint64_t sequence = 2; sequence <= samples; ++sequence) receive(sequence);
  });
  receiver.join();
  EXPECT_TRUE(sft::test::eventually([&] { return called == samples; })) << called;
  subscriber->close();
  EXPECT_EQ(disorder, 0);
  EXPECT_GT(by_dispatcher, 0);
  EXPECT_LT(by_dispatcher, static_cast<int>(samples));
}

}  // namespace
}  // namespace sft::core
