// Automatic recording of requirements, end to end: a subscriber requests the fields that the program reads.
#include <mutex>
#include <thread>
#include <vector>

#include "tests/system/fixture.h"

namespace sft::test {
namespace {

class RecordingTest : public PubSubTest {
 protected:
  explicit RecordingTest(bool as_remote = false) {
    sub.emplace(subscribe({.learn_samples = 3, .narrow_after_samples = 10, .as_remote = as_remote}).value());
    expect_served(pub, 1);
  }
  Result<Subscriber<PointCloud2, recorded>> subscribe(const SubscriberOptions::Recording& settings) {
    return b.subscriber<PointCloud2, recorded>("points", {.recording = settings});
  }

  /// Publishes one more sample and takes it.
  Sample<PointCloud2, recorded> next() {
    pub.publish(cloud(++published));
    return sub->wait(hang_timeout) ? sub->take() : Sample<PointCloud2, recorded>();
  }

  /// Publishes and reads until the publisher has applied `mask`. Every sample must be correct under the
  /// mask that the sample itself names.
  template <class Read>
  bool until_asked_for(const FieldMask& mask, Read read) {
    return eventually([&] {
      pub.publish(cloud(++published));
      if (!sub->wait(2s)) return false;
      while (const auto sample = sub->take()) {
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
  std::optional<Subscriber<PointCloud2, recorded>> sub;
  std::uint32_t published = 0;
};

TEST_P(RecordingTest, ItBeginsWithEverythingAndLearnsWhatIsRead) {
  EXPECT_TRUE(pub.status().readers.at(0).mask.is_full());
  EXPECT_TRUE(until_asked_for(FieldMask(F::width), [](const auto& sample) { EXPECT_TRUE(sample->width()); }));
  EXPECT_EQ(sub->status().mask, FieldMask(F::width));
  EXPECT_EQ(sub->status().lost, 0U);
}

TEST_P(RecordingTest, AFieldReadLaterIsAskedForAtOnceAndThenArrives) {
  ASSERT_TRUE(until_asked_for(FieldMask(F::width), [](const auto& sample) { (void)sample->width(); }));
  std::size_t missed = 0;
  ASSERT_TRUE(until_asked_for(FieldMask(F::width | F::height), [&](const auto& sample) {
    (void)sample->width();
    missed += sample->height() ? 0 : 1;
  }));
  // In shared memory samples have all fields, so that every read finds its field.
  EXPECT_EQ(missed == 0, in_shared_memory());
  const auto sample = next();
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

TEST_P(RecordingTest, ASampleThatWasKeptIsReadLaterByOtherThreads) {
  ASSERT_TRUE(until_asked_for(FieldMask(F::width), [](const auto& sample) { (void)sample->width(); }));
  auto kept = next();
  ASSERT_TRUE(kept);
  std::thread one([&] { (void)kept->height(); });
  std::thread other([&] { (void)kept->row_step(); });
  one.join();
  other.join();
  EXPECT_TRUE(eventually([&] {
    return pub.status().readers.at(0).mask == FieldMask(F::width | F::height | F::row_step);
  })) << "at once, though it is still held";
  EXPECT_EQ(sub->requirements().mask, FieldMask(F::width)) << "it counts when it is released";
  kept = {};
  EXPECT_EQ(sub->requirements().mask, FieldMask(F::width | F::height | F::row_step));
}

TEST_P(RecordingTest, ASampleIsReadAndReleasedWhenItsSubscriberAndNodeAreGone) {
  auto kept = next();
  ASSERT_TRUE(kept);
  sub.reset();
  static_cast<void>(Node(std::move(b)));
  std::thread([sample = std::move(kept)]() mutable {
    EXPECT_EQ(sample->width(), 2U);
    sample = {};
  }).join();
}

TEST_P(RecordingTest, ASampleThatACallbackKeptIsReadAfterwards) {
  std::mutex mutex;
  std::vector<Sample<PointCloud2, recorded>> kept;
  const auto keep = [&](Sample<PointCloud2, recorded> sample) {
    const std::scoped_lock lock(mutex);
    kept.push_back(std::move(sample));
  };
  const auto keeper =
      b.subscriber<PointCloud2, recorded>("points", keep, {.recording = {.learn_samples = 1}}).value();
  expect_served(pub, 2);
  pub.publish(cloud(7));
  ASSERT_TRUE(eventually([&] {
    const std::scoped_lock lock(mutex);
    return !kept.empty();
  }));
  EXPECT_EQ(keeper.requirements().samples, 0U);
  EXPECT_EQ(kept[0]->height(), 7U);
  kept.clear();
  EXPECT_EQ(keeper.requirements().samples, 1U);
  EXPECT_EQ(keeper.requirements().text, "height");
}

TEST_P(RecordingTest, RequirementsSayInHowManySamplesAFieldWasReadAndWhenLast) {
  for (int i = 1; i <= 5; ++i) {
    const auto sample = next();
    (void)sample->width();
    if (i == 2) (void)sample->height();
  }
  const Requirements seen = sub->requirements();
  EXPECT_TRUE(seen.recorded);
  EXPECT_EQ(seen.samples, 5U);
  EXPECT_EQ(seen.text, "height, width");
  EXPECT_EQ(seen.mask, FieldMask(F::height | F::width));
  ASSERT_EQ(seen.fields.size(), sub->type().leaves());
  EXPECT_EQ(seen.fields[3].path, "height");
  EXPECT_EQ(seen.fields[3].samples, 1U);
  EXPECT_EQ(seen.fields[3].last_sample, 2U);
  EXPECT_EQ(seen.fields[4].samples, 5U);
  EXPECT_EQ(seen.fields[4].last_sample, 5U);
  EXPECT_EQ(seen.fields[0].last_sample, 0U);
  EXPECT_TRUE(eventually([&] { return !sub->requirements().fields[0].requested; }));
  EXPECT_TRUE(sub->requirements().fields[3].requested);
}

TEST_P(RecordingTest, WhatWasRecordedCanBeDeclared) {
  for (int i = 0; i < 3; ++i) {
    const auto sample = next();
    (void)sample->header().stamp().sec();
    if (const auto fields = sample->fields()) (void)(*fields)[1].name();
  }
  const Requirements seen = sub->requirements();
  EXPECT_EQ(seen.text, "header.stamp.sec, fields.size, fields[].name");
  const auto declared =
      a.subscriber("points", a.find_type("points", hang_timeout).value(), seen.text).value();
  EXPECT_EQ(declared.requirements().mask, seen.mask);
}

TEST_P(RecordingTest, RequirementsOfADeclaredSubscriberAreWhatItDeclares) {
  const auto declared = b.subscriber<PointCloud2, F::fields.each.name>("points").value().requirements();
  EXPECT_FALSE(declared.recorded);
  EXPECT_EQ(declared.text, "fields.size, fields[].name");
  EXPECT_EQ(declared.mask, FieldMask(F::fields.size | F::fields.each.name));
  EXPECT_TRUE(declared.fields.at(5).requested);
  EXPECT_FALSE(declared.fields.at(4).requested);
  EXPECT_EQ(declared.samples, 0U);
}

TEST_P(RecordingTest, SettingsThatMakeNoSenseAreRefused) {
  const auto refused = subscribe({.learn_samples = 0});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Ways, RecordingTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

/// Tests that a subscriber with `as_remote` gets the same fields over every transport.
class AsRemoteTest : public RecordingTest {
 protected:
  AsRemoteTest() : RecordingTest(true) {}
};

TEST_P(AsRemoteTest, AFieldReadLaterIsMissedFirstAndThenArrives) {
  ASSERT_TRUE(until_asked_for(FieldMask(F::width), [](const auto& sample) { (void)sample->width(); }));
  const auto narrow = next();
  EXPECT_EQ(narrow.info().transport, in_shared_memory() ? TransportKind::shm : TransportKind::udp);
  EXPECT_EQ(narrow->height(), std::nullopt);
  EXPECT_EQ(narrow->width(), published + 1);
  const FieldMask wider(F::width | F::height);
  ASSERT_TRUE(eventually([&] { return pub.status().readers.at(0).mask == wider; }));
  const auto wide = next();
  EXPECT_EQ(wide->height(), published);
  EXPECT_EQ(narrow->height(), std::nullopt);
}

TEST_P(AsRemoteTest, ASamplesMaskBytesAndCopyAgree) {
  ASSERT_TRUE(until_asked_for(FieldMask(F::width), [](const auto& sample) { (void)sample->width(); }));
  const auto sample = next();
  EXPECT_EQ(sample.mask(), FieldMask(F::width));
  EXPECT_EQ(sample.cdr().size(), 8U);
  const Partial<PointCloud2> copy = sample.to_partial().value();
  EXPECT_EQ(copy.value.width, published + 1);
  EXPECT_EQ(copy.value.height, 0U);
}

TEST_P(AsRemoteTest, UnrequestedElementsAreThereWithoutTheirFields) {
  ASSERT_TRUE(until_asked_for(FieldMask(F::fields.size), [](const auto& sample) { (void)sample->fields(); }));
  const auto sample = next();
  const auto fields = sample->fields();
  ASSERT_TRUE(fields);
  ASSERT_EQ(fields->size(), 2U);
  for (const auto field : *fields) EXPECT_EQ(field.name(), std::nullopt);
  EXPECT_TRUE(until_asked_for(FieldMask(F::fields.size | F::fields.each.name), [](const auto& s) {
    for (const auto field : *s->fields()) (void)field.name();
  }));
}

INSTANTIATE_TEST_SUITE_P(Ways, AsRemoteTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

}  // namespace
}  // namespace sft::test
