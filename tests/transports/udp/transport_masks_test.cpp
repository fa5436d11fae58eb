// Many readers request different fields, and each reader gets its own.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "tests/transports/udp/endpoints.h"
#include "tests/transports/udp/faulty_io.h"
#include "tests/transports/udp/transport_fixture.h"

namespace sft::udp {
namespace {

using test::encoded_body;
using test::eventually;
using test::fields;
using test::Image;
using test::loopback_address;
using test::make_image;
using test::Publisher;
using test::Subscriber;

/// Readers behind one socket. Each reader has a mask of its own.
class Audience {
 public:
  explicit Audience(core::Network& here) : here_(here) {
    for (const char* scalar : {"", "stamp", "height", "stamp.sec, width"}) {
      for (const char* text : {"", ", name"}) {
        for (const char* bytes : {"", ", data"}) masks_.push_back(std::string(scalar) + text + bytes);
      }
    }
  }

  void ask(Publisher& publisher) {
    for (const std::string& mask : masks_) {
      subscribers_.push_back(std::make_unique<Subscriber>(here_, std::vector<std::string>{mask}));
      subscribers_.back()->listen_to(publisher.id());
      readers_.push_back({loopback_address(here_), mask});
    }
    publisher.serve(readers_);
  }
  /// Serves the readers in the reverse of their present order.
  void ask_in_reverse(Publisher& publisher) {
    std::reverse(readers_.begin(), readers_.end());
    publisher.serve(readers_);
  }

  const std::vector<std::string>& masks() const { return masks_; }
  Subscriber& subscriber(std::size_t number) { return *subscribers_[number]; }
  /// Expects each reader to get the samples with these sequences and no others.
  void expect_sequences(const std::vector<std::uint64_t>& sequences) {
    for (std::size_t i = 0; i < masks_.size(); ++i)
      EXPECT_EQ(subscribers_[i]->await_sequences(sequences.size()), sequences) << masks_[i];
  }

 private:
  core::Network& here_;
  std::vector<std::string> masks_;
  std::vector<std::unique_ptr<Subscriber>> subscribers_;
  std::vector<Publisher::Reader> readers_;
};

TEST_P(TransportTest, SendsEachReaderItsFields) {
  const auto there = open(), here = open();
  Publisher publisher(*there);
  Audience audience(*here);
  audience.ask(publisher);
  for (std::size_t n = 1; const std::size_t bytes : {10U, 20'000U, 1000U}) {
    EXPECT_EQ(publisher.publish(make_image(bytes)), core::SendStatus::sent);
    for (std::size_t i = 0; const std::string& mask : audience.masks()) {
      const auto samples = audience.subscriber(i++).await(n);
      ASSERT_EQ(samples.size(), n) << mask;
      EXPECT_EQ(test::body_of(*samples.back()), encoded_body(make_image(bytes), fields<Image>(mask))) << mask;
    }
    ++n;
  }
}

TEST_P(TransportTest, KeepsTheOrderUnderMoreMasksThanThePublishersThreadEncodes) {
  const auto there = open({.send_queue_depth = 100}), here = open();
  Publisher publisher(*there);
  Audience audience(*here);
  audience.ask(publisher);
  for (int i = 0; i < 60; ++i) {
    ASSERT_EQ(publisher.publish(make_image(i % 20 == 0 ? 60'000 : 50)), core::SendStatus::sent);
    audience.ask_in_reverse(publisher);
  }
  audience.expect_sequences(first_numbers(60));
}

/// The receiver answers only after all samples were published, so all of them wait in the sending thread.
TEST_P(TransportTest, KeepsTheOrderOfLargeSamplesToAReaderThatChangesItsMask) {
  test::Hold hold;
  const auto there = open();
  const auto here = open({}, [&](DatagramIo io) { return hold.put_around(std::move(io)); });
  const std::vector<std::string> masks{"*",           "data",         "data, name",
                                       "data, width", "data, height", "data, stamp"};
  Subscriber subscriber(*here, masks);
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  hold.begin();
  for (const std::string& mask : masks) {
    publisher.serve({{loopback_address(*here), mask}});
    EXPECT_EQ(publisher.publish(make_image(200'000)), core::SendStatus::sent);
  }
  EXPECT_TRUE(eventually([&] { return hold.stops_it(); }));
  hold.end();
  EXPECT_EQ(subscriber.await_sequences(masks.size()), first_numbers(masks.size()));
}

TEST_P(TransportTest, SendsUnderAllMasksAfterThePublisherWent) {
  const auto there = open(), here = open();
  Audience audience(*here);
  {
    Publisher publisher(*there);
    audience.ask(publisher);
    for (int i = 0; i < 3; ++i) publisher.publish(make_image(100'000));
  }
  audience.expect_sequences(first_numbers(3));
}

TEST_P(TransportTest, SendsLargeSamplesOfOneWriterOneAfterAnother) {
  const auto there = open();
  const auto here = open({.reassembly = {.unfinished_per_writer = 2}});
  Publisher publisher(*there);
  Audience audience(*here);
  audience.ask(publisher);
  for (int i = 0; i < 3; ++i) publisher.publish(make_image(1'000'000));
  audience.expect_sequences(first_numbers(3));
}

TEST_P(TransportTest, SendsReadersOfOneProcessOneCopy) {
  const auto there = open(), here = open();
  Subscriber one(*here, {"data"}), other(*here, {"data"});
  Publisher publisher(*there);
  one.listen_to(publisher.id());
  other.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here), "data"}, {loopback_address(*here), "data"}});
  publisher.publish(make_image(1000));
  EXPECT_EQ(one.await(1).size(), 1U);
  EXPECT_EQ(other.await(1).size(), 1U);
  EXPECT_EQ(publisher.port().counters().bytes_sent, FirstHeader{}.bytes_in_single() + 4 + 1000);
}

/// The first sample is measured. Each later sample is sent once for all 16 masks. Half of the masks include
/// the data.
TEST_P(TransportTest, SendsReadersOfOneProcessWithDifferentMasksOneCopyThatHasTheFieldsOfAll) {
  const auto there = open({.send_queue_depth = 100}), here = open();
  Publisher publisher(*there);
  Audience audience(*here);
  audience.ask(publisher);
  const Image image = make_image(20'000);
  ASSERT_EQ(publisher.publish(image), core::SendStatus::sent);
  for (std::size_t i = 0; i < audience.masks().size(); ++i)
    ASSERT_EQ(audience.subscriber(i).await(1).size(), 1U);
  there->poll(std::chrono::steady_clock::now());
  for (int i = 0; i < 20; ++i) ASSERT_EQ(publisher.publish(image), core::SendStatus::sent);
  audience.expect_sequences(first_numbers(21));
  const FieldMask all = fields<Image>("stamp, height, width, name, data");
  for (std::size_t i = 0; i < audience.masks().size(); ++i)
    EXPECT_EQ(audience.subscriber(i).await(21).back()->mask, all) << audience.masks()[i];
  std::size_t bodies = 20 * encoded_body(image, all).size();
  for (const std::string& mask : audience.masks()) bodies += encoded_body(image, fields<Image>(mask)).size();
  EXPECT_LT(static_cast<double>(publisher.port().counters().bytes_sent), 1.05 * static_cast<double>(bodies));
  for (std::size_t i = 0; i < audience.masks().size(); ++i)
    EXPECT_EQ(audience.subscriber(i).port().counters().discarded, 0U) << audience.masks()[i];
}

TEST_P(TransportTest, DeliversOnlyWhatIsConnectedAndAccepted) {
  const auto there = open(), here = open();
  Subscriber subscriber(*here, {"data"}), other(*here, {"*"});
  Publisher publisher(*there);
  EXPECT_FALSE(subscriber.port().connected(publisher.id()));
  subscriber.listen_to(publisher.id());
  other.listen_to(publisher.id());
  EXPECT_TRUE(subscriber.port().connected(publisher.id()));
  publisher.serve({{loopback_address(*here), "*"}});
  publisher.publish(make_image(10));
  EXPECT_EQ(other.await_sequences(1), first_numbers(1));
  EXPECT_FALSE(subscriber.port().take());

  other.port().disconnect(publisher.id());
  EXPECT_FALSE(other.port().connected(publisher.id()));
  const std::uint64_t unknown = here->counters().unknown;
  publisher.publish(make_image(10));
  EXPECT_TRUE(eventually([&] { return here->counters().unknown > unknown; }));
  EXPECT_EQ(other.await_sequences(1), first_numbers(1));
}

}  // namespace
}  // namespace sft::udp
