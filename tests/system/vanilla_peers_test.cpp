// Nodes of Cyclone DDS and of Fast DDS, each with code from its own generator, receive messages of SFT as
// structs and send them back. So each message is sent in both directions, and no byte of it may change.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <ostream>

#include "tests/support/recorded_data.h"
#include "tests/system/vanilla_fixture.h"

namespace sft::test {
namespace {

using testing::ElementsAre;

struct PeerCase {
  const char* program = "vanilla_echo";
  Way way = Way::udp;
  std::size_t host = 0;  ///< the number of the peer's host
  const char* reliability = "reliable";
};
void PrintTo(const PeerCase& one, std::ostream* out) { *out << one.program; }
std::string name_of_case(const testing::TestParamInfo<PeerCase>& one) {
  return std::string(one.param.program) + (one.param.way == Way::shm ? "_shm" : "_udp") +
         (one.param.host == 0 ? "_same_host_" : "_other_host_") + one.param.reliability;
}

class VanillaPeersTest : public VanillaTest {
 protected:
  /// Encodes the message anew. Fast DDS leaves the padding between members as its memory is.
  template <class Sample>
  static std::vector<std::byte> bytes_of(const Sample& sample) {
    const Result<PointCloud2> message = sample.to_owned();
    return message ? body_of(*message) : std::vector<std::byte>();
  }
  /// Publishes as often as it takes, since best effort may lose it. Returns the message that comes back.
  template <class P, class S>
  static std::vector<std::byte> body_after(P& publisher, S& subscriber, const PointCloud2& message) {
    std::vector<std::byte> body;
    eventually([&] {
      publisher.publish(message);
      if (!subscriber.wait(1s)) return false;
      const auto sample = subscriber.take();
      body = bytes_of(sample);
      return sample->height() == message.height;
    });
    return body;
  }
};

class VanillaEchoTest : public VanillaPeersTest, public testing::WithParamInterface<PeerCase> {
 protected:
  VanillaEcho peer(const VanillaEcho::How& how = {}) const {
    return {network_.host(GetParam().host),
            {.program = GetParam().program,
             .reliability = GetParam().reliability,
             .durability = how.durability,
             .depth = how.depth}};
  }
};

TEST_P(VanillaEchoTest, EachMessageComesBackWithItsBytes) {
  const Reliability wanted = GetParam().reliability == std::string("reliable") ? reliable : best_effort;
  Node node = open(GetParam().way);
  auto pub = node.publisher<PointCloud2>("points").value();
  auto sub = node.subscriber<PointCloud2>("echoed", {.reliability = wanted}).value();
  VanillaEcho echo = peer();
  ASSERT_TRUE(serves(pub, 1));
  ASSERT_TRUE(hears(sub, 1));
  ASSERT_TRUE(echo.matches(2));
  for (std::uint32_t i = 1; i <= 5; ++i) {
    const PointCloud2 sent = cloud(i, i < 5 ? 1000 + i : 300'000);  // with each padding
    EXPECT_EQ(body_after(pub, sub, sent), body_of(sent));
  }
}

class VanillaRecordedTest : public VanillaEchoTest {};

TEST_P(VanillaRecordedTest, RecordedCloudsComeBackWithTheirBytes) {
  Node node = open(GetParam().way);
  auto pub = node.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  auto direct = node.subscriber<PointCloud2>("points", {.reliability = reliable}).value();
  auto sub = node.subscriber<PointCloud2>("echoed", {.reliability = reliable}).value();
  VanillaEcho echo = peer();
  ASSERT_TRUE(serves(pub, 1) && hears(direct, 1) && hears(sub, 1) && echo.matches(2));
  for (const char* file : {"cdr/pointcloud2_dds_message.bin", "lidar3d/ouster/pointcloud2_0.cdr"}) {
    if (!std::filesystem::exists(recorded_data() / file)) GTEST_SKIP() << file << " is not there";
    const Payload recorded = read_recording(recorded_data() / file).value();
    ASSERT_EQ(pub.publish_cdr(recorded), PublishStatus::ok);
    ASSERT_TRUE(direct.wait(hang_timeout) && sub.wait(hang_timeout)) << file;
    const auto sent = direct.take(), came = sub.take();
    EXPECT_TRUE(std::equal(sent.cdr().begin() + 4, sent.cdr().end(), recorded.begin() + 4));
    EXPECT_TRUE(bytes_of(came) == bytes_of(sent)) << file;
  }
}

class VanillaReliablePeersTest : public VanillaEchoTest {};

TEST_P(VanillaReliablePeersTest, LatchedPeersGetAndRetainWhatWasPublishedBefore) {
  Node node = open(GetParam().way);
  auto pub =
      node.publisher<PointCloud2>("points", {.durability = transient_local, .history_depth = 3}).value();
  for (std::uint32_t i = 0; i < 5; ++i) pub.publish(cloud(i));
  VanillaEcho echo = peer({.durability = "latched", .depth = 3});
  ASSERT_TRUE(serves(pub, 1));
  auto sub = node.subscriber<PointCloud2>("echoed", {.durability = transient_local, .depth = 10}).value();
  std::vector<std::uint32_t> numbers;
  while (numbers.size() < 3 && sub.wait(hang_timeout)) {
    const auto sample = sub.take();
    numbers.push_back(sample->height());
  }
  EXPECT_THAT(numbers, ElementsAre(2, 3, 4));
}

TEST_P(VanillaReliablePeersTest, AfterAPeerWasStoppedItGoesOnAndAfterItWasKilledTheNextOneComes) {
  Node node = open(GetParam().way);
  auto pub = node.publisher<PointCloud2>("points").value();
  auto sub = node.subscriber<PointCloud2>("echoed", {.reliability = reliable}).value();
  VanillaEcho first = peer();
  ASSERT_TRUE(serves(pub, 1) && hears(sub, 1) && first.matches(2));
  expected_warning = "a reader of DDS does not acknowledge";  // if it does not go on soon
  first.hold_up();
  ASSERT_EQ(pub.publish(cloud(1)), PublishStatus::ok);
  first.let_go();
  EXPECT_EQ(body_after(pub, sub, cloud(2)), body_of(cloud(2)));
  first.kill_now();
  ASSERT_TRUE(serves(pub, 0) && hears(sub, 0));
  VanillaEcho second = peer();
  ASSERT_TRUE(serves(pub, 1) && hears(sub, 1) && second.matches(2));
  EXPECT_EQ(body_after(pub, sub, cloud(3)), body_of(cloud(3)));
}

/// Cyclone DDS has other tests in vanilla_dds_test and vanilla_writers_test.
constexpr PeerCase of_cyclone[] = {{"vanilla_echo", Way::udp, 0}, {"vanilla_echo", Way::udp, 1}};
INSTANTIATE_TEST_SUITE_P(Cyclone, VanillaRecordedTest, testing::ValuesIn(of_cyclone), name_of_case);

#if SFT_HAS_FAST_DDS
constexpr PeerCase of_fast_dds[] = {{"fast_dds_echo", Way::udp, 0},
                                    {"fast_dds_echo", Way::udp, 1},
                                    {"fast_dds_echo", Way::udp, 1, "best_effort"},
                                    {"fast_dds_echo", Way::shm, 0},
                                    {"fast_dds_echo", Way::shm, 1, "best_effort"}};
constexpr PeerCase reliable_fast_dds[] = {{"fast_dds_echo", Way::udp, 0}, {"fast_dds_echo", Way::udp, 1}};
INSTANTIATE_TEST_SUITE_P(FastDds, VanillaEchoTest, testing::ValuesIn(of_fast_dds), name_of_case);
INSTANTIATE_TEST_SUITE_P(FastDds, VanillaRecordedTest, testing::ValuesIn(reliable_fast_dds), name_of_case);
INSTANTIATE_TEST_SUITE_P(FastDds, VanillaReliablePeersTest, testing::ValuesIn(reliable_fast_dds),
                         name_of_case);
#else
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(VanillaEchoTest);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(VanillaReliablePeersTest);
#endif

}  // namespace
}  // namespace sft::test
