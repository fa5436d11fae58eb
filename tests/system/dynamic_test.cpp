// Programs that are compiled without the type of a topic. They find the type, read fields of the topic by
// name and print samples, over every transport.
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gmock/gmock.h>

#include <cstring>
#include <mutex>
#include <nav_msgs/msg/Odometry.hpp>

#include "core/control/described_type.h"
#include "core/discovery/discovery.h"
#include "core/platform/domain_id.h"
#include "sft/detail/type_description.h"
#include "sft/detail/type_shape.h"
#include "tests/support/isolated_host.h"
#include "tests/support/small_cloud.h"
#include "tests/system/fixture.h"

namespace sft::test {
namespace {

using namespace detail;

using ::testing::HasSubstr;

/// The role of another process, which is compiled with the message type.
[[noreturn]] void publish_forever(Way way) {
  Node node = Node::open(node_options(way, "publisher")).value();
  auto publisher = node.publisher<PointCloud2>("points").value();
  for (;;) {
    publisher.publish(small_cloud());
    poll(nullptr, 0, 5);
  }
}

class PublisherProcess {
 public:
  explicit PublisherProcess(Way way) {
    char self[] = "/proc/self/exe";
    std::string number = std::to_string(static_cast<int>(way));
    char* arguments[] = {self, const_cast<char*>("--publish"), number.data(), nullptr};
    if (posix_spawn(&pid_, self, nullptr, nullptr, arguments, environ) != 0) pid_ = -1;
  }
  ~PublisherProcess() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  PublisherProcess(const PublisherProcess&) = delete;
  PublisherProcess& operator=(const PublisherProcess&) = delete;

 private:
  pid_t pid_ = -1;
};

class DynamicTest : public PubSubTest {
 protected:
  Node a = open("a");
  Node b = open("b");
};

TEST_P(DynamicTest, WhatAnotherProcessPublishesIsPrintedWithoutItsType) {
  const PublisherProcess publisher(GetParam());
  const auto type = b.find_type("points", hang_timeout);
  ASSERT_TRUE(type) << type.error().message;
  auto sub = b.subscriber("points", *type, "header, fields[].name, width, data").value();
  ASSERT_TRUE(sub.wait(15s));
  const DynamicSample sample = sub.take();
  EXPECT_EQ(sample.info().transport, in_shared_memory() ? TransportKind::shm : TransportKind::udp);
  const std::string expected =
      "header:\n"
      "  stamp:\n"
      "    sec: 7\n"
      "    nanosec: 0\n"
      "  frame_id: lidar\n"
      "width: 1024\n"
      "fields:\n"
      "- name: x\n"
      "- name: \"y\"\n"
      "data: [9, 9, 9]  # ... 197 more\n";
  EXPECT_EQ(sample.to_yaml({.elements_max = 3}).value(), expected);
}

TEST_P(DynamicTest, ItsMaskIsWhatThePublisherServes) {
  auto pub = a.publisher<PointCloud2>("points").value();
  const DynamicType type = b.find_type("points", hang_timeout).value();
  auto sub = b.subscriber("points", type, "header.stamp fields[].name").value();
  expect_served(pub, 1);
  EXPECT_EQ(pub.status().readers[0].mask, FieldMask(F::header.stamp | F::fields.size | F::fields.each.name));
  pub.publish(small_cloud());
  ASSERT_TRUE(sub.wait(hang_timeout));
  const DynamicSample sample = sub.take();
  EXPECT_EQ(sample.view()["header"]["stamp"]["sec"].as<int>(), 7);
  EXPECT_EQ(sample.view()["fields"][1]["name"].as<std::string>(), "y");
  EXPECT_EQ(sample.info().transport, in_shared_memory() ? TransportKind::shm : TransportKind::udp);
  EXPECT_TRUE(sample.view()["height"].is_absent());
  EXPECT_TRUE(sample.view()["fields"][1]["offset"].is_absent());
  EXPECT_EQ(sample.mask(), FieldMask(F::header.stamp | F::fields.size | F::fields.each.name));
  EXPECT_EQ(sample.cdr().size(), 4U + 8 + 4 + 2 * 8 - 2);
  EXPECT_EQ(sample.cdr().data(), sample.cdr().data()) << "it is made once";
  EXPECT_EQ(sample.to_json().value(),
            R"({"header":{"stamp":{"sec":7,"nanosec":0}},"fields":[{"name":"x"},{"name":"y"}]})");
  EXPECT_FALSE(sample.malformed());
  EXPECT_EQ(sub.status().received, 1U);
}

TEST_P(DynamicTest, AsRemoteLeavesASampleOnlyTheDeclaredFieldsInSharedMemoryToo) {
  auto pub = a.publisher<PointCloud2>("points").value();
  const DynamicType type = b.find_type("points", hang_timeout).value();
  auto sub = b.subscriber("points", type, "width, fields[].name", {.recording = {.as_remote = true}}).value();
  expect_served(pub, 1);
  pub.publish(small_cloud());
  ASSERT_TRUE(sub.wait(hang_timeout));
  const DynamicSample sample = sub.take();
  EXPECT_EQ(sample.to_json().value(), R"({"width":1024,"fields":[{"name":"x"},{"name":"y"}]})");
  EXPECT_EQ(sub.status().received, 1U);
}

TEST_P(DynamicTest, ASubscriberThatDeclaresOnlyALengthSeesNoElements) {
  auto pub = a.publisher<PointCloud2>("points").value();
  const DynamicType type = b.find_type("points", hang_timeout).value();
  auto sub = b.subscriber("points", type, "fields.size").value();
  auto whole = b.subscriber<PointCloud2>("points").value();  // ensures that the sample may have all fields
  expect_served(pub, 2);
  pub.publish(small_cloud());
  ASSERT_TRUE(sub.wait(hang_timeout));
  DynamicSample sample = sub.take();
  const DynamicSample moved = std::move(sample);
  EXPECT_EQ(moved.to_json().value(), R"({"fields.size":2})");
  EXPECT_EQ(moved.cdr().size(), 8U);
}

/// Returns a cloud with points of four float32 each: 0, 1, 2, 3, then 4, 5, 6, 7, and so on.
PointCloud2 numbered_cloud(std::uint32_t points) {
  PointCloud2 cloud = small_cloud("lidar", 0);
  cloud.width = points;
  cloud.point_step = 16;
  cloud.row_step = points * 16;
  cloud.fields.clear();
  for (const char* name : {"x", "y", "z", "intensity"}) {
    const auto offset = static_cast<std::uint32_t>(4 * cloud.fields.size());
    cloud.fields.push_back({.name = name, .offset = offset, .datatype = 7, .count = 1});
  }
  cloud.data.resize(cloud.row_step);
  for (std::uint32_t i = 0; i < 4 * points; ++i) {
    const auto value = static_cast<float>(i);
    std::memcpy(&cloud.data[4 * i], &value, sizeof value);
  }
  return cloud;
}

std::vector<float> numbers_in(std::span<const std::uint8_t> data) {
  std::vector<float> numbers(data.size() / sizeof(float));
  std::memcpy(numbers.data(), data.data(), numbers.size() * sizeof(float));
  return numbers;
}

TEST_P(DynamicTest, APartOfAFieldIsASmallerMessageOfTheSameType) {
  auto pub = a.publisher<PointCloud2>("points").value();
  const DynamicType type = b.find_type("points", hang_timeout).value();
  auto sub = b.subscriber("points", type, "data{x,z}[1:4:2]").value();
  expect_served(pub, 1);
  EXPECT_FALSE(pub.status().readers[0].mask.contains(*type.support().find("header")->begin()));
  for (const std::uint64_t received : {1U, 2U}) {
    pub.publish(numbered_cloud(received == 1 ? 1000 : 50'000));
    ASSERT_TRUE(sub.wait(hang_timeout));
    const DynamicSample sample = received == 1 ? sub.take() : sub.take_latest();
    EXPECT_EQ(sample.info().transport, in_shared_memory() ? TransportKind::shm : TransportKind::udp);
    EXPECT_EQ(sample.to_json().value(),
              R"({"height":1,"width":2,"fields":[{"name":"x","offset":0,"datatype":7,"count":1},)"
              R"({"name":"z","offset":4,"datatype":7,"count":1}],"is_bigendian":false,"point_step":8,)"
              R"("row_step":16,"data":"AACAQAAAwEAAAEBBAABgQQ=="})");
    const auto data = sample.view()["data"].as<std::span<const std::uint8_t>>();
    ASSERT_TRUE(data);
    EXPECT_EQ(numbers_in(*data), (std::vector<float>{4, 6, 12, 14}));
    EXPECT_EQ(sub.status().received, received);
    EXPECT_EQ(sub.status().lost, 0U);
    if (!in_shared_memory()) {
      EXPECT_LT(pub.status().bytes_sent, received * 200) << "of 16 kB";
    }
  }
}

TEST_P(DynamicTest, PartsOfLargeMessagesComeToAllWhoAskForThem) {
  constexpr auto reliable = Reliability::reliable;
  auto pub = a.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  const DynamicType type = b.find_type("points", hang_timeout).value();
  auto every_fourth = b.subscriber("points", type, "data{intensity}[::4]", {.reliability = reliable}).value();
  auto three = b.subscriber("points", type, "header, data{y,z,intensity}").value();
  expect_served(pub, 2);
  constexpr std::uint32_t points = 100'000;
  for (int round = 0; round < 3; ++round) {
    pub.publish(numbered_cloud(points));
    ASSERT_TRUE(every_fourth.wait(hang_timeout));
    ASSERT_TRUE(three.wait(hang_timeout));
    const DynamicSample quarter = every_fourth.take(), most = three.take();
    const auto some = numbers_in(quarter.view()["data"].as<std::span<const std::uint8_t>>().value());
    ASSERT_EQ(some.size(), points / 4);
    for (std::uint32_t i = 0; i < some.size(); ++i) ASSERT_EQ(some[i], static_cast<float>(16 * i + 3));
    const auto others = numbers_in(most.view()["data"].as<std::span<const std::uint8_t>>().value());
    ASSERT_EQ(others.size(), 3 * points);
    for (std::uint32_t i = 0; i < others.size(); ++i)
      ASSERT_EQ(others[i], static_cast<float>(4 * (i / 3) + 1 + i % 3));
    EXPECT_EQ(most.view()["header"]["frame_id"].as<std::string>(), "lidar");
  }
}

TEST_P(DynamicTest, APartOfAMessageThatContradictsItselfIsEmpty) {
  auto pub = a.publisher<PointCloud2>("points").value();
  const DynamicType type = b.find_type("points", hang_timeout).value();
  auto sub = b.subscriber("points", type, "data{x}").value();
  expect_served(pub, 1);
  PointCloud2 cloud = numbered_cloud(5);
  cloud.width = 6;
  pub.publish(cloud);
  ASSERT_TRUE(sub.wait(hang_timeout));
  const DynamicSample sample = sub.take();
  EXPECT_EQ(sample.view()["width"].as<int>(), 0);
  EXPECT_EQ(sample.view()["data"].size(), 0U);
  EXPECT_FALSE(sample.malformed());
}

TEST_P(DynamicTest, AWrongPartIsAnErrorThatNamesTheColumn) {
  auto pub = a.publisher<PointCloud2>("points").value();
  const DynamicType type = b.find_type("points", hang_timeout).value();
  const auto error_of = [&](const char* fields) {
    return b.subscriber("points", type, fields).error().message;
  };
  EXPECT_THAT(error_of("width, data{x}[::0]"), HasSubstr("column 18: a step of 0 keeps nothing"));
  EXPECT_THAT(error_of("width[1:2]"), HasSubstr("column 1: 'width' has no parts"));
  EXPECT_THAT(error_of("data @ every 0th"), HasSubstr("column 14: samples are counted from the 1st on"));
}

TEST_P(DynamicTest, ACallbackGetsSamples) {
  auto pub = a.publisher<PointCloud2>("points").value();
  const DynamicType type = b.find_type("points", hang_timeout).value();
  std::mutex mutex;
  std::vector<std::uint32_t> widths;
  auto sub = b.subscriber("points", type, "width", {}, [&](const DynamicSample& sample) {
    const std::scoped_lock lock(mutex);
    widths.push_back(sample.view()["width"].as<std::uint32_t>().value());
  });
  ASSERT_TRUE(sub);
  expect_served(pub, 1);
  for (int i = 0; i < 3; ++i) pub.publish(small_cloud());
  EXPECT_TRUE(eventually([&] {
    const std::scoped_lock lock(mutex);
    return widths == std::vector<std::uint32_t>{1024, 1024, 1024};
  }));
}

TEST_P(DynamicTest, ATypeLivesAsLongAsWhatUsesIt) {
  auto pub = a.publisher<PointCloud2>("points").value();
  std::optional<DynamicSample> last;
  for (int round = 0; round < 10; ++round) {
    std::optional<DynamicSubscriber> sub =
        b.subscriber("points", b.find_type("points", hang_timeout).value(), "width").value();
    expect_served(pub, 1);
    pub.publish(small_cloud());
    ASSERT_TRUE(sub->wait(hang_timeout));
    last = sub->take();
    pub.publish(small_cloud());  // the sample is under way or in the queue when `sub` is destroyed
    sub.reset();
    EXPECT_EQ(last->view()["width"].as<int>(), 1024);
    expect_served(pub, 0);
  }
}

TEST_P(DynamicTest, CompiledAndDynamicSubscribersOfOneNodeGetTheSame) {
  auto pub = a.publisher<PointCloud2>("points").value();
  auto compiled = b.subscriber<PointCloud2>("points").value();
  auto dynamic = b.subscriber("points", b.find_type("points", hang_timeout).value(), "*").value();
  expect_served(pub, 2);
  pub.publish(small_cloud());
  ASSERT_TRUE(compiled.wait(hang_timeout) && dynamic.wait(hang_timeout));
  const auto one = compiled.take();
  const DynamicSample other = dynamic.take();
  EXPECT_TRUE(std::equal(one.cdr().begin(), one.cdr().end(), other.cdr().begin(), other.cdr().end()));
}

TEST_P(DynamicTest, FieldsThatAreReadByNameAreRecorded) {
  auto pub = a.publisher<PointCloud2>("points").value();
  const DynamicType type = b.find_type("points", hang_timeout).value();
  auto sub = b.subscriber("points", type, recorded,
                          {.recording = {.learn_samples = 1, .narrow_after_samples = 20, .as_remote = true}})
                 .value();
  expect_served(pub, 1);
  const auto asked_for = [&](const FieldMask& mask, auto read) {
    return eventually([&] {
      pub.publish(small_cloud());
      if (!sub.wait(5s)) return false;
      while (const DynamicSample sample = sub.take()) read(sample.view());
      return pub.status().readers.at(0).mask == mask;
    });
  };
  EXPECT_TRUE(asked_for(FieldMask(F::width), [](const DynamicView& v) { (void)v["width"].as<int>(); }));
  EXPECT_TRUE(
      asked_for(FieldMask(F::height), [](const DynamicView& v) { (void)static_cast<bool>(v["height"]); }));
  EXPECT_TRUE(asked_for(FieldMask(F::fields.size), [](const DynamicView& v) { (void)v["fields"].size(); }));
  EXPECT_TRUE(asked_for(FieldMask(F::fields.size | F::fields.each.name), [](const DynamicView& v) {
    for (const DynamicView& field : v["fields"].elements()) (void)field["name"].as<std::string_view>();
  }));
  EXPECT_TRUE(asked_for(FieldMask(F::header.stamp.sec), [](const DynamicView& v) {
    if (const DynamicView header = v["header"]) (void)header["stamp"]["sec"].as<int>();
  }));
  EXPECT_EQ(sub.requirements().text, "header.stamp.sec, height, width, fields.size, fields[].name");
}

TEST_P(DynamicTest, PrintingASampleReadsAllOfIt) {
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber("points", b.find_type("points", hang_timeout).value(), recorded,
                          {.recording = {.learn_samples = 1}})
                 .value();
  expect_served(pub, 1);
  pub.publish(small_cloud());
  ASSERT_TRUE(sub.wait(hang_timeout));
  EXPECT_TRUE(sub.take().to_yaml());
  EXPECT_EQ(sub.requirements().text, "*");
}

INSTANTIATE_TEST_SUITE_P(Ways, DynamicTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

// ---- errors and log lines ----

class DynamicNodesTest : public ::testing::Test {
 protected:
  static Node udp_node(const std::string& name) { return Node::open(node_options(Way::udp, name)).value(); }

  /// Returns another definition of PointCloud2, with a wider height.
  static DynamicType taller() {
    std::vector<Member> members(TypeTable<PointCloud2>::members.begin(),
                                TypeTable<PointCloud2>::members.end());
    members[1].kind = Kind::uint64;
    return DynamicType::parse(describe(StructType(TypeTable<PointCloud2>::type.name, members))).value();
  }
};

TEST_F(DynamicNodesTest, ATopicThatNobodyPublishesIsAnErrorThatSaysWhatWasSeen) {
  Node a = udp_node("a");
  Node b = udp_node("b");
  EXPECT_THAT(b.find_type("points", 0s).error().message,
              HasSubstr("nobody publishes or subscribes to 'points'"));
  auto pub = a.publisher<nav_msgs::msg::Odometry>("odom").value();
  ASSERT_TRUE(b.find_type("odom", hang_timeout));
  const auto missing = b.find_type("points", 1ms);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, Errc::unavailable);
  EXPECT_THAT(missing.error().message, HasSubstr("topics that were seen: odom"));
}

TEST_F(DynamicNodesTest, AnUnknownFieldIsAnErrorThatNamesTheNearest) {
  Node a = udp_node("a");
  auto pub = a.publisher<PointCloud2>("points").value();
  const auto sub =
      a.subscriber("points", a.find_type("points", hang_timeout).value(), "header.stamp, hieght");
  ASSERT_FALSE(sub);
  EXPECT_EQ(sub.error().code, Errc::unknown_field);
  EXPECT_THAT(sub.error().message, HasSubstr("has no field 'hieght'; did you mean 'height'?"));
}

TEST_F(DynamicNodesTest, ATypeIsLearntFromASubscriberIfNobodyPublishes) {
  Node a = udp_node("a");
  Node b = udp_node("b");
  auto sub = a.subscriber<PointCloud2>("points").value();
  const auto type = b.find_type("points", hang_timeout);
  ASSERT_TRUE(type) << type.error().message;
  EXPECT_EQ(type->support().name(), TypeTable<PointCloud2>::type.name);
}

TEST_F(DynamicNodesTest, TopicsAreListedWithTypesFieldsAndNodes) {
  Node a = udp_node("a");
  Node b = udp_node("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2, F::width>("points").value();
  ASSERT_TRUE(eventually([&] {
    const auto topics = b.topics();
    return topics.size() == 1 && topics[0].types.size() == 1 && topics[0].types[0].publishers.size() == 1;
  }));
  const TopicInfo topic = b.topics().at(0);
  EXPECT_EQ(topic.name, "points");
  EXPECT_EQ(topic.types[0].publishers[0], "a");
  EXPECT_EQ(topic.types[0].subscribers.at(0), "b");
  EXPECT_EQ(topic.types[0].type->support().path(3), "height");
}

TEST_F(DynamicNodesTest, AnotherDefinitionOfTheTypeIsExplainedToBothSidesAndLoggedOnce) {
  std::mutex mutex;
  std::vector<std::string> logged;
  const auto node = [&](const char* name) {
    NodeOptions options = node_options(Way::udp, name);
    options.log = [&](LogLevel level, std::string_view text) {
      const std::scoped_lock lock(mutex);
      if (level >= LogLevel::warning) logged.emplace_back(text);
    };
    return Node::open(options).value();
  };
  Node a = node("a");
  Node b = node("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber("points", taller(), "height").value();
  ASSERT_TRUE(
      eventually([&] { return pub.status().readers.size() == 1 && sub.status().writers.size() == 1; }));
  const PublisherStatus::Reader reader = pub.status().readers[0];
  EXPECT_FALSE(reader.served);
  EXPECT_EQ(
      reader.reason,
      "two different definitions of type sensor_msgs::msg::PointCloud2: height: uint32 here, uint64 there");
  const SubscriberStatus::Writer writer = sub.status().writers[0];
  EXPECT_FALSE(writer.matched);
  EXPECT_EQ(writer.mismatch->difference, "height: uint64 here, uint32 there");
  EXPECT_THAT(writer.mismatch->here, HasSubstr("uint64 height;"));
  EXPECT_THAT(writer.mismatch->there, HasSubstr("uint32 height;"));
  auto more = b.subscriber("points", taller(), "width").value();  // causes all pairs to be compared again
  ASSERT_TRUE(eventually([&] { return pub.status().readers.size() == 2; }));
  EXPECT_TRUE(eventually([&] {
    const std::scoped_lock lock(mutex);
    return logged.size() == 2;  // one line of each side, although two pairs do not match
  }));
  EXPECT_THAT(logged[0], HasSubstr("topic 'points', node '"));
}

TEST_F(DynamicNodesTest,
       DescriptionsThatLieAreCountedAndLeftOutAndTheEndpointStaysAndAFloodOfThemIsLoggedOnce) {
  NodeOptions options = node_options(Way::udp, "a");
  std::atomic<int> complaints{0};
  options.log = [&](LogLevel, std::string_view text) {
    complaints += text.find("control traffic refused") != std::string_view::npos ? 1 : 0;
  };
  Node node = Node::open(options).value();
  auto sub = node.subscriber<PointCloud2>("points").value();

  auto other = core::Discovery::open({.domain = core::domain_id({}, std::getenv("ROS_DOMAIN_ID")).value(),
                                      .threads = {.name_prefix = "liar"}},
                                     [] {});
  ASSERT_TRUE(other) << other.error().message;
  const auto announce = [&](core::EndpointId id, std::vector<std::byte> description) {
    core::Endpoint e;
    e.id = id;
    e.role = core::Role::writer;
    e.node = "liar";
    e.topic = "points";
    e.type_name = TypeTable<PointCloud2>::type.name;
    e.type_hash = structure_hash(TypeTable<PointCloud2>::type);
    e.type_description = std::move(description);
    (*other)->announce(e);
  };
  announce(1, std::vector<std::byte>(100, std::byte{0xff}));
  announce(2, describe(TypeTable<nav_msgs::msg::Odometry>::type));
  announce(3, describe(TypeTable<PointCloud2>::type));
  EXPECT_TRUE(eventually([&] { return sub.status().writers.size() == 3; }));
  EXPECT_EQ(node.status().control_malformed, 2U);
  for (const SubscriberStatus::Writer& writer : sub.status().writers) EXPECT_EQ(writer.mismatch, nullptr);
  EXPECT_TRUE(node.find_type("points", 0s));
  const auto begun = std::chrono::steady_clock::now();
  for (core::EndpointId id = 10; id < 210; ++id) announce(id, std::vector<std::byte>(100, std::byte{0xff}));
  EXPECT_TRUE(eventually([&] { return node.status().control_malformed == 202; }));
  const auto seconds = (std::chrono::steady_clock::now() - begun) / 1s;
  {
    const auto last_of_node = std::move(sub);
    const Node ends = std::move(node);  // its destructor writes all pending lines
  }
  EXPECT_GE(complaints, 1);
  EXPECT_LE(complaints, 3 + seconds);
}

}  // namespace
}  // namespace sft::test

int main(int argc, char** argv) {
  if (argc == 3 && std::strcmp(argv[1], "--publish") == 0)
    sft::test::publish_forever(static_cast<sft::test::Way>(std::atoi(argv[2])));
  ::testing::InitGoogleTest(&argc, argv);
  if (GTEST_FLAG_GET(list_tests)) return RUN_ALL_TESTS();
  return sft::test::run_isolated([] {
    // Without isolation the test at least uses a DDS domain that other programs here do not use.
    const std::string domain = std::to_string(100 + getpid() % 100);
    if (!sft::test::isolation_refusal().empty()) setenv("ROS_DOMAIN_ID", domain.c_str(), 1);
    return RUN_ALL_TESTS();
  });
}
