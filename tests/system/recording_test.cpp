// Automatic requirement recording, end to end: what is read is what is asked for.
#include "tests/system/fixture.h"

namespace sft::test {
namespace {

class RecordingTest : public PubSubTest {
 protected:
  RecordingTest() { expect_served(pub, 1); }

  /// Publishes and reads until the publisher has applied `mask`; every sample must be right under the mask it
  /// names.
  template <class Read>
  bool until_asked_for(const FieldMask& mask, Read read) {
    return eventually([&] {
      pub.publish(cloud(++published));
      if (!sub.wait(2s)) return false;
      while (const auto sample = sub.take()) {
        if (const auto height = sample.to_partial()->value.height; sample.mask().contains(3)) {
          EXPECT_EQ(height, static_cast<std::uint32_t>(sample.info().sequence));
        }
        read(sample);
      }
      const auto readers = pub.status().readers;
      return readers.size() == 1 && readers[0].mask == mask;
    });
  }

  Node a = open("a");
  Node b = open("b");
  Publisher<PointCloud2> pub = a.publisher<PointCloud2>("points").value();
  Subscriber<PointCloud2, recorded> sub =
      b.subscriber<PointCloud2, recorded>("points",
                                          {.recording = {.learn_samples = 3, .narrow_after_samples = 10}})
          .value();
  std::uint32_t published = 0;
};

TEST_P(RecordingTest, ItBeginsWithEverythingAndLearnsWhatIsRead) {
  EXPECT_TRUE(pub.status().readers.at(0).mask.is_full());
  EXPECT_TRUE(until_asked_for(FieldMask(F::width), [](const auto& sample) { EXPECT_TRUE(sample->width()); }));
  EXPECT_EQ(sub.status().mask, FieldMask(F::width));
  EXPECT_EQ(sub.status().lost, 0U);
}

TEST_P(RecordingTest, AFieldReadLaterIsAskedForAtOnceAndThenArrives) {
  ASSERT_TRUE(until_asked_for(FieldMask(F::width), [](const auto& sample) { (void)sample->width(); }));
  std::size_t missed = 0;
  ASSERT_TRUE(until_asked_for(FieldMask(F::width | F::height), [&](const auto& sample) {
    (void)sample->width();
    missed += sample->height() ? 0 : 1;
  }));
  // In shared memory the sample has everything, and no read ever misses.
  EXPECT_EQ(missed == 0, in_shared_memory());
  pub.publish(cloud(++published));
  ASSERT_TRUE(sub.wait(2s));
  const auto sample = sub.take();
  EXPECT_EQ(sample->height(), published);
}

TEST_P(RecordingTest, AFieldNoLongerReadIsGivenUp) {
  ASSERT_TRUE(until_asked_for(FieldMask(F::width | F::height), [](const auto& sample) {
    (void)sample->width();
    (void)sample->height();
  }));
  EXPECT_TRUE(until_asked_for(FieldMask(F::width), [](const auto& sample) { (void)sample->width(); }));
}

TEST_P(RecordingTest, ElementsOfSequencesAreRecordedLeafByLeaf) {
  EXPECT_TRUE(until_asked_for(FieldMask(F::fields.size | F::fields.each.name), [](const auto& sample) {
    if (const auto fields = sample->fields()) {
      for (const auto field : *fields) (void)field.name();
    }
  }));
}

INSTANTIATE_TEST_SUITE_P(Ways, RecordingTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

}  // namespace
}  // namespace sft::test
