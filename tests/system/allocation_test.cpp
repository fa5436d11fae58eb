// In steady state a program's own thread allocates no memory when it publishes, takes or reads a sample.
#include "tests/support/thread_allocations.h"
#include "tests/system/fixture.h"

namespace sft::test {
namespace {

class AllocationTest : public PubSubTest {
 protected:
  /// Counts the allocations of this thread over 200 samples. 50 further samples are passed before these, to
  /// warm up.
  template <class Pass>
  static std::uint64_t allocations_of(Pass pass) {
    for (int i = 0; i < 50; ++i) pass();
    const std::uint64_t before = thread_allocations();
    for (int i = 0; i < 200; ++i) pass();
    return thread_allocations() - before;
  }

  Node a = open("a");
  Node b = open("b");
  Publisher<PointCloud2> pub = a.publisher<PointCloud2>("points").value();
};

TEST_P(AllocationTest, PublishingAndReadingDeclaredFieldsAllocatesNothing) {
  auto sub = b.subscriber<PointCloud2, F::height | F::fields>("points").value();
  expect_served(pub, 1);
  const PointCloud2 message = cloud(1);
  std::uint64_t sum = 0;
  EXPECT_EQ(allocations_of([&] {
              pub.publish(message);
              if (!sub.wait(hang_timeout)) return;
              const auto sample = sub.take();
              sum += sample->height();
              for (const auto field : sample->fields()) sum += field.name().size();
            }),
            0U);
  EXPECT_GE(sum, 250U);
}

TEST_P(AllocationTest, JumpingToElementsOfEachSampleAllocatesNothing) {
  auto sub = b.subscriber<PointCloud2, F::fields>("points").value();
  expect_served(pub, 1);
  PointCloud2 message = cloud(1);
  message.fields.resize(50);
  for (std::size_t i = 0; i < 50; ++i) message.fields[i].name = std::to_string(i);
  std::uint64_t sum = 0;
  EXPECT_EQ(allocations_of([&] {
              pub.publish(message);
              if (!sub.wait(hang_timeout)) return;
              const auto sample = sub.take();
              sum += sample->fields()[40].name().size() + sample->fields().back().name().size();
            }),
            0U);
  EXPECT_GE(sum, 240U * 4);
}

TEST_P(AllocationTest, LoansAndRecordedReadersAllocateNothing) {
  auto sub = b.subscriber<PointCloud2, recorded>("points").value();
  expect_served(pub, 1);
  const PointCloud2 prototype = cloud(1, 0);
  std::uint64_t read = 0;
  const auto pass = [&] {
    auto loan = pub.loan(prototype, {.data = 3000});
    loan->shrink(F::data, 2000);
    std::move(*loan).publish();
    if (!sub.wait(hang_timeout)) return;
    const auto sample = sub.take();
    read += sample->width() && sample->data() ? 1 : 0;
  };
  // After 100 recorded samples the subscriber requests only the fields that it reads. This also changes the
  // samples that it expects.
  const auto asked_for = [&] { return pub.status().readers.at(0).mask; };
  const FieldMask all = asked_for();
  // These passes also last until the receiver has sent its first report. After this report more samples may
  // be under way.
  for (int i = 0; i < 400; ++i) pass();
  ASSERT_TRUE(eventually([&] {
    pass();
    return asked_for() != all;
  }));
  read = 0;
  EXPECT_EQ(allocations_of(pass), 0U);
  EXPECT_GE(read, 240U);
}

INSTANTIATE_TEST_SUITE_P(Ways, AllocationTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

}  // namespace
}  // namespace sft::test
