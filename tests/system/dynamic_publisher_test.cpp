// Publishers in a program that was not compiled with their message types.
#include <gmock/gmock.h>

#include <algorithm>
#include <optional>

#include "sft/detail/type_description.h"
#include "tests/support/encoded.h"
#include "tests/support/message_types.h"
#include "tests/support/random_value.h"
#include "tests/support/tame_value.h"
#include "tests/system/fixture.h"

namespace sft::test {
namespace {

using namespace detail;

using ::testing::HasSubstr;

DynamicType cloud_type() { return DynamicType::parse(describe(TypeTable<PointCloud2>::type)).value(); }

class DynamicPublisherTest : public PubSubTest {
 protected:
  Node a = open("a");
  Node b = open("b");
};

TEST_P(DynamicPublisherTest, ACompiledSubscriberReadsWhatWasPublishedAsJson) {
  auto pub = a.publisher("points", cloud_type()).value();
  auto sub = b.subscriber<PointCloud2, F::width | F::fields.each.name>("points").value();
  expect_served(pub, 1);
  EXPECT_EQ(pub.publish_json(R"({"width": 1024, "fields": [{"name": "x"}, {"name": "y"}]})"),
            PublishStatus::ok);
  ASSERT_TRUE(sub.wait(hang_timeout));
  const auto sample = sub.take();
  EXPECT_EQ(sample->width(), 1024U);
  EXPECT_EQ(sample->fields()[1].name(), "y");
}

TEST_P(DynamicPublisherTest, ACompiledSubscriberReadsWhatWasPublishedAsYamlWithTheTimeInIt) {
  auto pub = a.publisher("points", cloud_type()).value();
  auto sub = b.subscriber<PointCloud2>("points").value();
  expect_served(pub, 1);
  const auto before = std::chrono::system_clock::now();
  EXPECT_EQ(pub.publish_yaml("{header: {stamp: now, frame_id: lidar}, fields: [{name: x}]}"),
            PublishStatus::ok);
  ASSERT_TRUE(sub.wait(hang_timeout));
  const auto sample = sub.take();
  EXPECT_EQ(sample->header().frame_id(), "lidar");
  EXPECT_EQ(sample->fields()[0].name(), "x");
  EXPECT_GE(to_time(sample->header().stamp()), before);
  EXPECT_LE(to_time(sample->header().stamp()), std::chrono::system_clock::now());
  EXPECT_EQ(pub.publish_yaml("width: wide").error().message,
            "'width' is \"wide\"; an integer from 0 to 4294967295 was expected");
}

TEST_P(DynamicPublisherTest, EncodedPayloadsGoOutAsTheyAre) {
  auto pub = a.publisher("points", cloud_type()).value();
  auto sub = b.subscriber<PointCloud2>("points").value();
  expect_served(pub, 1);
  const PointCloud2 sent = cloud(7);
  std::vector<std::byte> payload{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
  const std::vector<std::byte> body = Encoded(sent).bytes();
  payload.insert(payload.end(), body.begin(), body.end());
  EXPECT_EQ(pub.publish_cdr(payload), PublishStatus::ok);
  ASSERT_TRUE(sub.wait(hang_timeout));
  EXPECT_EQ(sub.take().to_owned(), sent);
  EXPECT_FALSE(pub.publish_cdr(std::span(payload).first(20)));
}

TEST_P(DynamicPublisherTest, ALoanOfCdrIsReadWhereItWasWritten) {
  auto pub = a.publisher("points", cloud_type()).value();
  auto sub = b.subscriber<PointCloud2>("points").value();
  expect_served(pub, 1);
  const PointCloud2 sent = cloud(7);
  const std::vector<std::byte> body = Encoded(sent).bytes();
  DynamicPublisher::Loan loan = pub.loan_cdr(body.size()).value();
  ASSERT_EQ(loan.body().size(), body.size());
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(loan.body().data()) % 8, 0U);
  std::ranges::copy(body, loan.body().begin());
  EXPECT_EQ(std::move(loan).publish(), PublishStatus::ok);
  EXPECT_TRUE(loan.body().empty());
  EXPECT_EQ(std::move(loan).publish(), PublishStatus::no_loan);
  ASSERT_TRUE(sub.wait(hang_timeout));
  EXPECT_EQ(sub.take().to_owned(), sent);
}

TEST_P(DynamicPublisherTest, ALoanOfCdrThatIsNoMessageIsNotPublished) {
  auto pub = a.publisher("points", cloud_type(), {.max_sample_bytes = 1000}).value();
  auto sub = b.subscriber<PointCloud2, F::width>("points").value();
  expect_served(pub, 1);
  DynamicPublisher::Loan loan = pub.loan_cdr(40).value();
  std::ranges::fill(loan.body(), std::byte{0xFF});
  EXPECT_THAT(std::move(loan).publish().error().message, HasSubstr("not a sensor_msgs::msg::PointCloud2"));
  EXPECT_THAT(pub.loan_cdr(1001).error().message, HasSubstr("max_sample_bytes"));
  static_cast<void>(pub.loan_cdr(40).value());  // it is given back
  EXPECT_EQ(pub.publish_json(R"({"width": 5})"), PublishStatus::ok);
  ASSERT_TRUE(sub.wait(hang_timeout));
  const auto sample = sub.take();
  EXPECT_EQ(sample->width(), 5U);
  EXPECT_EQ(sample.info().sequence, 1U);
}

TEST_P(DynamicPublisherTest, WhatIsWrongWithTheJsonIsAnErrorAlsoWithoutReaders) {
  auto pub = a.publisher("points", cloud_type(), {.max_sample_bytes = 1000}).value();
  EXPECT_EQ(pub.publish_json(R"({"header": {"stamp": {"sec": "now"}}})").error().message,
            R"('header.stamp.sec' is "now"; an integer from -2147483648 to 2147483647 was expected)");
  EXPECT_THAT(pub.publish_json("{\"data\": \"" + std::string(4000, 'A') + "\"}").error().message,
              HasSubstr("'data' is where the message has more than 1000 bytes"));
}

TEST_P(DynamicPublisherTest, ItsTypeLivesAsLongAsItIsNeeded) {
  std::optional<DynamicPublisher> pub = a.publisher("points", cloud_type()).value();
  auto sub = b.subscriber<PointCloud2, F::width>("points").value();
  expect_served(*pub, 1);
  EXPECT_EQ(pub->publish_json(R"({"width": 1})"), PublishStatus::ok);
  pub.reset();  // its samples may still be under way
  pub = a.publisher("points", cloud_type()).value();
  expect_served(*pub, 1);
  ASSERT_TRUE(eventually([&] {
    EXPECT_EQ(pub->publish_json(R"({"width": 2})"), PublishStatus::ok);
    const auto sample = sub.take_latest();
    return sample && sample->width() == 2;
  }));
}

INSTANTIATE_TEST_SUITE_P(Ways, DynamicPublisherTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

class EveryTypeByJson : public RandomTest {};

TEST_F(EveryTypeByJson, IsWhatADynamicSubscriberGetsOfADynamicPublisher) {
  Node node = Node::open(node_options(Way::udp, "node")).value();
  RandomValues values{random};
  for (const MessageType& each : every_type()) {
    SCOPED_TRACE(each.support->name());
    const DynamicType type = DynamicType::parse(describe(each.type())).value();
    auto pub = node.publisher("everything", type, {.reliability = reliable}).value();
    auto sub = node.subscriber("everything", type, "*", {.reliability = reliable}).value();
    ASSERT_TRUE(eventually([&] {
      const auto readers = pub.status().readers;
      return std::ranges::any_of(readers,
                                 [](const PublisherStatus::Reader& reader) { return reader.served; });
    }));
    OwnedValue value = each.make();
    values.fill(value.type(), value.get());
    tame(value.type(), value.get());
    const Encoded expected(value.type(), value.get(), each.support->full());
    const std::string json = to_json(DynamicView(expected.state(), type.type())).value();
    const auto status = pub.publish_json(json);
    ASSERT_TRUE(status) << status.error().message;
    ASSERT_TRUE(sub.wait(10s));
    const DynamicSample sample = sub.take();
    const auto body = sample.cdr().subspan(4);
    const std::vector<std::byte> bytes = expected.bytes();
    EXPECT_TRUE(std::ranges::equal(body, bytes)) << json;
    EXPECT_EQ(sample.to_json().value(), json);
  }
}

}  // namespace
}  // namespace sft::test
