// One publisher and readers of parts of a field on one bridge, each on a host of its own. The tests check the
// traffic and the samples that arrive.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/transports/udp/bridge_fixture.h"
#include "udp_transport/multicast/plan_cost.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {
namespace {

constexpr std::size_t samples_weighed = 100;

class PartFanOutTest : public test::BridgeTest, public testing::WithParamInterface<bool> {
 protected:
  void SetUp() override {
    if (!sft::test::isolation_refusal().empty()) GTEST_SKIP() << sft::test::isolation_refusal();
    if (!make_bridge("") || !test::run("ip address add 10.20.0.1/24 dev bridge && ip link set bridge up"))
      GTEST_SKIP() << "no bridge can be made here";
    open_publisher();
  }

  /// Makes a reader for each selection in `asked`, each on a host of its own.
  void make_readers(const std::vector<std::string>& asked) {
    for (const std::string& one : asked)
      ASSERT_TRUE(add_reader(static_cast<unsigned>(hosts_.size()) + 2, one, GetParam()));
    serve(asked.size());
  }
  double bytes_of_one_sample() {
    publish();
    const std::uint32_t before = test::traffic_of("bridge").sent;
    publish(samples_weighed);
    return static_cast<double>(test::traffic_of("bridge").sent - before) / samples_weighed;
  }
  /// Returns the image with that number, reduced to each `step`th byte.
  static test::Image thinned(std::uint32_t number, std::size_t step) {
    test::Image image = test::make_image(data_bytes, number);
    image.name.assign(name_bytes, 'n');
    std::vector<std::uint8_t> kept;
    for (std::size_t i = 0; i < image.data.size(); i += step) kept.push_back(image.data[i]);
    image.data = std::move(kept);
    return image;
  }
  /// Expects the samples of the reader to be complete and in order, and to have the content that they name.
  /// Returns the number of samples with a part.
  std::size_t check(std::size_t reader, std::size_t step) {
    const auto samples = hosts_[reader].subscriber->await(published_ - hosts_[reader].since);
    EXPECT_EQ(samples.size(), published_ - hosts_[reader].since);
    const Selection asked = test::selection_of<test::Image>(hosts_[reader].mask);
    std::size_t parts = 0;
    std::uint32_t number = hosts_[reader].since;
    for (const core::SampleHandle& sample : samples) {
      ++number;
      EXPECT_EQ(sample->sequence, number);
      EXPECT_TRUE(sample->mask.contains(asked.mask()));
      EXPECT_TRUE(sample->parts == asked.parts_hash() || (sample->parts == 0 && sample->merged));
      const std::size_t taken = sample->parts == 0 ? 1 : step;
      EXPECT_EQ(test::body_of(*sample), test::encoded_body(thinned(number, taken), sample->mask)) << number;
      parts += sample->parts == 0 ? 0 : 1;
    }
    return parts;
  }
};

INSTANTIATE_TEST_SUITE_P(Each, PartFanOutTest, testing::Bool(),
                         [](const auto& param) { return param.param ? "Reliable" : "BestEffort"; });

TEST_P(PartFanOutTest, SendsFourHostsThatAskForTheSamePartOneCopyOfIt) {
  make_readers({"stamp, data[::2]", "stamp, data[::2]", "stamp, data[::2]", "stamp, data[::2]"});
  ASSERT_TRUE(publish_until([this] { return all_are_in_groups(); })) << publisher_->port().multicast(1);
  const double bytes = bytes_of_one_sample();
  const double one_copy = wire_bytes(8 + 4 + data_bytes / 2.0, datagram_bytes_max, PlaceMark::in_group);
  std::printf("bytes for each sample: %.0f, of one copy %.0f\n", bytes, one_copy);
  EXPECT_LT(bytes, 1.25 * one_copy) << "heartbeats and acks count, too";
  for (std::size_t reader = 0; reader < 4; ++reader)
    EXPECT_EQ(check(reader, 2), published_ - hosts_[reader].since) << "each gets just its part";
}

TEST_P(PartFanOutTest, SendsOneCopyOfTheWholeFieldWhereManyAskForDifferentPartsOfIt) {
  make_readers({"data", "data[1:]", "data[2:]", "data[3:]"});
  ASSERT_TRUE(publish_until([this] { return all_are_in_groups(); })) << publisher_->port().multicast(1);
  const double bytes = bytes_of_one_sample();
  EXPECT_LT(bytes, 1.25 * wire_bytes(4 + data_bytes, datagram_bytes_max, PlaceMark::in_group));
  EXPECT_TRUE(all_came());
}

TEST_P(PartFanOutTest, ServesWholePartAndScalarsBesideEachOther) {
  make_readers({"*", "*", "stamp, data[::4]", "stamp, data[::4]", "stamp, data[::4]", "height, width"});
  ASSERT_TRUE(publish_until([this] { return hears(1) && hears(2) && hears(3) && hears(4) && hears(5); }))
      << publisher_->port().multicast(3);
  const double bytes = bytes_of_one_sample();
  const double whole = wire_bytes(data_bytes + name_bytes + 40, datagram_bytes_max, PlaceMark::in_group);
  const double scalars = wire_bytes(8, datagram_bytes_max, PlaceMark::none);
  std::printf("bytes for each sample: %.0f, of one copy of the whole %.0f\n", bytes, whole);
  EXPECT_LT(bytes, 1.25 * (whole + scalars));
  for (const std::size_t reader : {0U, 1U, 5U}) EXPECT_EQ(check(reader, 1), 0U);
  for (const std::size_t reader : {2U, 3U, 4U}) check(reader, 4);
}

/// Both readers are of one transport, as in a single program.
TEST_P(PartFanOutTest, SendsAProcessWithTwoReadersOfAPartOneCopy) {
  make_readers({"data[::2]"});
  const double one_reader = bytes_of_one_sample();
  ASSERT_TRUE(all_came()) << "the second reader is to hear those that follow only";
  test::Subscriber second(*hosts_[0].transport, std::vector<std::string>{"data[::2]"}, 10'000, 2);
  GetParam() ? second.listen_reliably_to(publisher_->id()) : second.listen_to(publisher_->id());
  const std::uint32_t since = published_;
  publisher_->serve(
      {{hosts_[0].address, "data[::2]", GetParam()}, {hosts_[0].address, "data[::2]", GetParam()}});
  EXPECT_LT(bytes_of_one_sample(), 1.1 * one_reader);
  EXPECT_EQ(second.await(published_ - since).size(), published_ - since);
  EXPECT_TRUE(all_came());
}

/// The reader whose part changes leaves its group, is served alone, and then joins another group.
TEST_P(PartFanOutTest, LosesNothingWhileAReaderChangesItsPart) {
  const std::string third = "data[::3]", half = "data[::2]";
  make_readers({third, third, half, half});
  ASSERT_TRUE(publish_until([this] { return all_are_in_groups(); })) << publisher_->port().multicast(1);
  std::vector<core::Accepted> accepted{{.wanted = {test::selection_of<test::Image>(third)}},
                                       {.wanted = {test::selection_of<test::Image>(half)}}};
  hosts_[0].subscriber->port().accept(accepted);
  for (int round = 0; round < 6; ++round) {
    std::vector<test::Publisher::Reader> readers;
    for (const Host& host : hosts_) readers.push_back({host.address, host.mask, host.reliable});
    readers[0].mask = round % 2 == 0 ? half : third;
    publisher_->serve(readers);
    publish(3);
    if (round == 4) {
      ASSERT_TRUE(publish_until([this] { return hears(1); })) << publisher_->port().multicast(1);
    }
  }
  const auto samples = hosts_[0].subscriber->await(published_);
  ASSERT_EQ(samples.size(), published_);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i]->sequence, i + 1);
    const bool is_half = samples[i]->parts == test::selection_of<test::Image>(half).parts_hash();
    EXPECT_EQ(
        test::body_of(*samples[i]),
        test::encoded_body(thinned(static_cast<std::uint32_t>(i + 1), is_half ? 2 : 3), samples[i]->mask));
  }
  for (const std::size_t reader : {1U, 2U, 3U}) EXPECT_EQ(check(reader, reader == 1 ? 3 : 2), published_);
}

}  // namespace
}  // namespace sft::udp
