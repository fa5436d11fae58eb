// Pairs that never match. Both sides get the reason, and no sample is sent.
#include "tests/pairs/fixture.h"

namespace sft::test {
namespace {

struct Misfit {
  std::string policy;
  json offered;
  json requested;
  const char* text;
};

void PrintTo(const Misfit& misfit, std::ostream* out) { *out << misfit.text; }

class Policies : public NegotiationTest, public testing::WithParamInterface<Misfit> {};

TEST_P(Policies, ThatDoNotFitAreToldToBothSidesAndNothingIsSent) {
  const Misfit& misfit = GetParam();
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  Peer fitting(there(), "fitting");
  publisher.advertise(misfit.offered);
  reader.subscribe("*", misfit.requested);
  fitting.subscribe("height, width");
  ASSERT_TRUE(agree(publisher, fitting));
  EXPECT_TRUE(comes_true([&] {
    return was_notified(publisher.status()["offered"], "incompatible QoS", misfit.text) &&
           was_notified(reader.status()["requested"], "incompatible QoS", misfit.text);
  })) << publisher.status()
      << reader.status();
  publisher.publish(10);
  EXPECT_TRUE(accounts_for_all(publisher, fitting));
  EXPECT_EQ(reader_of(publisher, reader)["policy"], misfit.policy);
  EXPECT_EQ(writer_of(publisher, reader)["policy"], misfit.policy);
  EXPECT_FALSE(is_served(publisher, reader));
  EXPECT_FALSE(writer_of(publisher, reader)["matched"]);
  EXPECT_TRUE(reader.status()["taken"].empty());
  EXPECT_EQ(taken_of(publisher, fitting)["masks"].size(), 1);
}

INSTANTIATE_TEST_SUITE_P(
    Each, Policies,
    testing::Values(Misfit{"reliability",
                           {},
                           {{"reliable", true}},
                           "reliability best_effort is offered, reliable is requested"},
                    Misfit{"durability",
                           {},
                           {{"transient_local", true}},
                           "durability volatile is offered, transient_local is requested"},
                    Misfit{"deadline",
                           {{"deadline_ms", 200}},
                           {{"deadline_ms", 100}},
                           "deadline 200 ms is offered, 100 ms is requested"},
                    Misfit{"liveliness",
                           {},
                           {{"manual_by_topic", true}},
                           "liveliness automatic is offered, manual_by_topic is requested"},
                    Misfit{"liveliness",
                           {{"lease_ms", 2000}},
                           {{"lease_ms", 1000}},
                           "liveliness_lease 2000 ms is offered, 1000 ms is requested"}),
    [](const auto& misfit) { return misfit.param.policy + std::to_string(misfit.index); });

class Types : public NegotiationTest {
 protected:
  void expect_no_match(const std::string& fields, const std::string& reason_at_publisher,
                       const std::string& reason_at_reader) {
    Peer publisher(here(), "publisher");
    Peer reader(there(), "reader");
    Peer fitting(there(), "fitting");
    publisher.advertise();
    reader.subscribe(fields);
    fitting.subscribe("height, width");
    ASSERT_TRUE(agree(publisher, fitting));
    EXPECT_TRUE(comes_true([&] {
      return was_notified(publisher.status()["offered"], "incompatible type", reason_at_publisher) &&
             was_notified(reader.status()["requested"], "incompatible type", reason_at_reader);
    })) << publisher.status()
        << reader.status();
    publisher.publish(10);
    EXPECT_TRUE(accounts_for_all(publisher, fitting));
    EXPECT_FALSE(is_served(publisher, reader));
    EXPECT_FALSE(writer_of(publisher, reader)["matched"]);
    EXPECT_TRUE(reader.status()["taken"].empty());
  }
};

TEST_F(Types, OfOtherNamesNeverMatchAndBothSidesAreToldThem) {
  const std::string reported =
      "type sensor_msgs::msg::PointCloud2 is published, sensor_msgs::msg::Image is subscribed to";
  expect_no_match("image", reported, reported);
}

TEST_F(Types, OfOneNameWithTwoDefinitionsNeverMatchAndBothSidesAreToldTheDifference) {
  expect_no_match("taller", "height: uint32 here, uint64 there", "height: uint64 here, uint32 there");
}

}  // namespace
}  // namespace sft::test
