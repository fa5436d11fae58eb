// Tests to which ports a sample is sent, and which readers count as having received it.
#include "core/publish/dispatch.h"

#include <gtest/gtest.h>

#include <sensor_msgs/msg/PointCloud2.hpp>

#include "tests/unit/core/publish/port_logs.h"

namespace sft::core::test {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using Calls = std::vector<std::string>;

class DispatchTest : public ::testing::Test {
 protected:
  void serve(Serving serving, std::shared_ptr<LendingWriter> lending = nullptr) {
    dispatch.serve(serving, std::move(lending));
    {
      const Dispatch::Call call(dispatch);  // the first Call that uses these outlets
    }
    network->take();
  }
  void serve_one_by_network() {
    Serving serving;
    serving.network = {network_route(1, type)};
    serve(serving);
  }
  /// Serves two readers in shared memory. The first reader also has a fallback route over the network.
  void serve_two_in_memory() {
    Serving serving;
    serving.memory = {memory_route(1, type), memory_route(2, type)};
    serving.fallback = {network_route(1, type)};
    serving.fallback[0].fallback = true;
    serve(serving, memory);
  }
  PublishStatus send(std::int64_t stamp_ns = 1) {
    const Dispatch::Call call(dispatch);
    Dispatch::Admission admission = dispatch.admit(FieldSource::of_nothing(), stamp_ns);
    if (!admission.passes) return dispatch.withhold();
    return dispatch.send(make_sample(*pool, type), stamp_ns, std::move(admission), hang_timeout);
  }

  const TypeSupport type{TypeTable<PointCloud2>::type};
  const std::shared_ptr<BufferPool> pool = BufferPool::make(1 << 20);
  const std::shared_ptr<NetworkLog> network = std::make_shared<NetworkLog>();
  const std::shared_ptr<MemoryLog> memory = std::make_shared<MemoryLog>();
  const std::shared_ptr<DeliveryBook> book = std::make_shared<DeliveryBook>();
  std::chrono::nanoseconds hang_timeout{0};
  Dispatch dispatch{{&type, network, book, nullptr, false}};
};

TEST_F(DispatchTest, WantsNothingWhileNobodyReads) {
  const Dispatch::Call call(dispatch);
  EXPECT_FALSE(call.outlets().is_wanted);
}

TEST_F(DispatchTest, BeginsASampleOnTheNetworkBeforeItSendsIt) {
  serve_one_by_network();
  EXPECT_EQ(send(), PublishStatus::ok);
  EXPECT_EQ(network->take(), (Calls{"begin", "send begun"}));
}

TEST_F(DispatchTest, LetsATransmissionGoOfASampleThatNoGatePasses) {
  Serving serving;
  serving.network = {network_route(1, type)};
  serving.network[0].min_period_us = 1'000'000;
  serve(serving);
  constexpr std::int64_t now_ns = 5'000'000'000;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(send(now_ns), PublishStatus::ok);
  EXPECT_EQ(network->take(), (Calls{"begin", "send begun", "begin", "begin"}));
  EXPECT_EQ(dispatch.published(), 3U);
}

TEST_F(DispatchTest, EndsWhatTheNetworkCountsOnceNobodyReadsThere) {
  serve_one_by_network();
  send();
  Serving nobody;
  dispatch.serve(nobody, nullptr);
  network->take();
  const Dispatch::Call call(dispatch);
  EXPECT_EQ(network->take(), (Calls{"begin"})) << "so that the counts of the last reader end";
}

TEST_F(DispatchTest, ASampleThatPushesAnotherOneOutOfAQueueIsSentAndCountsAsDropped) {
  serve_two_in_memory();
  memory->answer = SendStatus::displaced;
  EXPECT_EQ(send(), PublishStatus::dropped);
  EXPECT_EQ(dispatch.dropped(), 1U);
  EXPECT_EQ(book->of(1), (Delivered{.sent = 1}));
  EXPECT_EQ(dispatch.diverted(), PublisherStatus::Diverted{});
}

TEST_F(DispatchTest, TellsWhoPublishesThatARouteDidNotGetTheSample) {
  serve_one_by_network();
  network->answer = SendStatus::dropped;
  EXPECT_EQ(send(), PublishStatus::dropped);
  EXPECT_EQ(dispatch.dropped(), 1U);
}

TEST_F(DispatchTest, CopiesASampleThatWasMadeElsewhereIntoSharedMemory) {
  serve_two_in_memory();
  EXPECT_EQ(send(), PublishStatus::ok);
  ASSERT_EQ(memory->sent.size(), 1U);
  EXPECT_TRUE(memory->owns(*memory->sent[0]));
  EXPECT_EQ(memory->sent[0]->sequence, 1U);
  EXPECT_EQ(network->take(), (Calls{"local turn", "begin", "local turn over"}))
      << "nothing goes by a fallback route";
  EXPECT_EQ(book->of(1), (Delivered{.sent = 1}));
}

TEST_F(DispatchTest, SendsByFallbackRoutesWhatSharedMemoryDoesNotTakeAndOthersMissIt) {
  serve_two_in_memory();
  memory->is_full = true;
  EXPECT_EQ(send(), PublishStatus::dropped);
  EXPECT_EQ(network->take(),
            (Calls{"local turn", "begin", "send begun, by fallbacks too", "local turn over"}));
  EXPECT_EQ(book->of(1), Delivered{}) << "the port to the network counts that";
  EXPECT_EQ(book->of(2), (Delivered{.dropped = 1}));
}

TEST_F(DispatchTest, HandsEachWholeSampleToReadersOfDdsBesideWhateverElseItIsFor) {
  const auto vanilla = std::make_shared<VanillaLog>();
  Serving serving;
  serving.network = {network_route(1, type)};
  serving.network[0].min_period_us = 1'000'000;
  dispatch.serve(serving, nullptr, vanilla);
  constexpr std::int64_t now_ns = 5'000'000'000;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(send(now_ns), PublishStatus::ok);
  EXPECT_EQ(vanilla->sent.size(), 3U) << "no gate is theirs";
  dispatch.serve(serving, nullptr);
  send(now_ns);
  EXPECT_EQ(vanilla->sent.size(), 3U);
}

TEST_F(DispatchTest, EncodesAllFieldsForReadersOfDdsAndPostponesNoCopies) {
  Serving serving;
  serving.network = {network_route(1, type)};
  serving.network[0].selection = FieldMask(type.closed(type.none()));
  serve(serving);
  {
    const Dispatch::Call call(dispatch);
    EXPECT_FALSE(call.outlets().whole);
    EXPECT_TRUE(dispatch.may_postpone());
  }
  dispatch.serve(serving, nullptr, std::make_shared<VanillaLog>());
  const Dispatch::Call call(dispatch);
  EXPECT_TRUE(call.outlets().whole);
  EXPECT_FALSE(dispatch.may_postpone());
}

TEST_F(DispatchTest, TellsTheNetworkWhenReadersInSharedMemoryHaveTheirTurn) {
  serve_one_by_network();
  send();
  EXPECT_EQ(network->take(), (Calls{"begin", "send begun"})) << "there are none";
  Serving serving;
  serving.network = {network_route(1, type)};
  serving.memory = {memory_route(2, type)};
  serve(serving, memory);
  {
    const Dispatch::Call call(dispatch);
    EXPECT_EQ(network->take(), Calls{"local turn"}) << "before anything is encoded";
  }
  EXPECT_EQ(network->take(), Calls{"local turn over"}) << "also if nothing was sent";
  send();
  EXPECT_EQ(network->take(), (Calls{"local turn", "begin", "send begun", "local turn over"}));
}

TEST_F(DispatchTest, CountsWhySharedMemoryDidNotTakeASample) {
  serve_two_in_memory();
  memory->is_full = true;
  send();
  memory->largest_bytes = 0;
  send();
  send();
  memory->is_full = false;
  memory->answer = SendStatus::lost_port;
  send();
  const PublisherStatus::Diverted diverted = dispatch.diverted();
  EXPECT_EQ(diverted.exhausted, 1U);
  EXPECT_EQ(diverted.too_large, 2U);
  EXPECT_EQ(diverted.unavailable, 1U);
  EXPECT_GT(diverted.too_large_bytes, 0U) << "the largest one";
  EXPECT_EQ(diverted.chunk_bytes, 0U) << "as the port says then";
}

TEST_F(DispatchTest, ASampleIsTooLargeOnlyIfItIsLargerThanTheLargestChunk) {
  serve_two_in_memory();
  memory->is_full = true;
  constexpr std::uint32_t body_bytes = 1000;
  const std::size_t bytes = SampleLayout(type.index_slots()).bytes(body_bytes);
  for (const std::size_t largest : {bytes, bytes - 1}) {
    memory->largest_bytes = largest;
    const Dispatch::Call call(dispatch);
    EXPECT_EQ(dispatch.miss(dispatch.admit(FieldSource::of_nothing(), 1), body_bytes),
              PublishStatus::no_memory);
  }
  EXPECT_EQ(dispatch.diverted(),
            (PublisherStatus::Diverted{
                .exhausted = 1, .too_large = 1, .too_large_bytes = bytes, .chunk_bytes = bytes - 1}));
}

TEST_F(DispatchTest, NamesTheLargestSampleThatWasTooLargeAlsoIfASmallerOneWasSoLater) {
  serve_two_in_memory();
  memory->is_full = true;
  memory->largest_bytes = 100;
  const auto miss = [&](std::uint32_t body_bytes) {
    const Dispatch::Call call(dispatch);
    dispatch.miss(dispatch.admit(FieldSource::of_nothing(), 1), body_bytes);
  };
  for (const std::uint32_t body_bytes : {1000, 3000, 2000}) miss(body_bytes);
  EXPECT_EQ(dispatch.diverted().too_large, 3U);
  EXPECT_EQ(dispatch.diverted().too_large_bytes, SampleLayout(type.index_slots()).bytes(3000));
}

TEST_F(DispatchTest, TellsReadersInSharedMemoryWhichSampleWentOverTheNetworkAlone) {
  serve_two_in_memory();
  memory->is_full = true;
  send(7);
  memory->is_full = false;
  send(8);
  ASSERT_EQ(memory->sent.size(), 1U);
  EXPECT_EQ(memory->sent[0]->diverted_sequence, 1U);
  EXPECT_EQ(memory->sent[0]->diverted_stamp_ns, 7);
}

TEST_F(DispatchTest, SaysThatASampleIsMissingThatCouldNotBeMade) {
  Serving serving;
  serving.network = {network_route(1, type)};
  serving.memory = {memory_route(2, type)};
  serve(serving, memory);
  const Dispatch::Call call(dispatch);
  network->take();
  EXPECT_EQ(dispatch.miss(dispatch.admit(FieldSource::of_nothing(), 1), 8), PublishStatus::no_memory);
  EXPECT_EQ(network->take(), (Calls{"begin", "miss"}));
  EXPECT_EQ(book->of(2), (Delivered{.dropped = 1}));
  EXPECT_EQ(dispatch.published(), 1U) << "readers see a gap";
  EXPECT_EQ(dispatch.dropped(), 1U);
}

TEST_F(DispatchTest, PostponesCopiesOnlyForTheNetworkAlone) {
  serve_one_by_network();
  {
    const Dispatch::Call call(dispatch);
    EXPECT_TRUE(dispatch.may_postpone());
  }
  Serving both;
  both.network = {network_route(1, type)};
  both.memory = {memory_route(2, type)};
  serve(both, memory);
  const Dispatch::Call call(dispatch);
  EXPECT_FALSE(dispatch.may_postpone()) << "others look at the same sample";
}

/// A publisher that retains its samples.
class DurableDispatchTest : public DispatchTest {
 protected:
  History history{3, 0};
  Dispatch durable{{&type, network, book, &history, false}};
};

TEST_F(DurableDispatchTest, MakesEverySampleAndBeginsItOnceItIsInTheHistory) {
  const Dispatch::Call call(durable);
  EXPECT_TRUE(call.outlets().is_wanted) << "by late readers";
  Dispatch::Admission admission = durable.admit(FieldSource::of_nothing(), 1);
  EXPECT_TRUE(admission.passes);
  EXPECT_FALSE(admission.transmission);
  durable.send(make_sample(*pool, type), 1, std::move(admission), hang_timeout);
  EXPECT_EQ(history.last(3, 0).size(), 1U);
}

TEST_F(DurableDispatchTest, SendsByTheOutletsThatCameIntoForceMeanwhile) {
  Serving serving;
  serving.network = {network_route(1, type)};
  durable.serve(serving, nullptr);
  const Dispatch::Call call(durable);
  EXPECT_EQ(
      durable.send(make_sample(*pool, type), 1, durable.admit(FieldSource::of_nothing(), 1), hang_timeout),
      PublishStatus::ok);
  EXPECT_EQ(network->take().back(), "send");
  Serving nobody;
  durable.serve(nobody, nullptr);  // does not wait for `call`, since the outlets in force allow this change
  network->take();
  EXPECT_EQ(
      durable.send(make_sample(*pool, type), 2, durable.admit(FieldSource::of_nothing(), 2), hang_timeout),
      PublishStatus::ok);
  EXPECT_EQ(network->take(), (Calls{"begin"})) << "nobody reads there any more";
  EXPECT_FALSE(call.outlets().to_network) << "a call that goes on goes by these";
}

TEST_F(DurableDispatchTest, BeginsASampleLateThatGoesByFallbackRoutes) {
  Serving serving;
  serving.memory = {memory_route(1, type)};
  serving.fallback = {network_route(1, type)};
  serving.fallback[0].fallback = true;
  durable.serve(serving, memory);
  memory->is_full = true;
  const Dispatch::Call call(durable);
  network->take();
  EXPECT_EQ(
      durable.send(make_sample(*pool, type), 1, durable.admit(FieldSource::of_nothing(), 1), hang_timeout),
      PublishStatus::ok);
  EXPECT_EQ(network->take(), (Calls{"begin", "send begun, by fallbacks too"}));
}

TEST_F(DurableDispatchTest, PostponesNoCopies) {
  Serving serving;
  serving.network = {network_route(1, type)};
  durable.serve(serving, nullptr);
  const Dispatch::Call call(durable);
  EXPECT_FALSE(durable.may_postpone()) << "a late reader may get the sample";
}

}  // namespace
}  // namespace sft::core::test
