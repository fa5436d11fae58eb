// Rows "Mask change" and "Duplicates and reordering" of negotiation.md: requests that change while samples
// are under way.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tests/pairs/fixture.h"

namespace sft::test {
namespace {

class Requests : public NegotiationTest {
 protected:
  /// Returns the names of one or more random fields, in the printed form of masks.
  std::string random_fields() {
    constexpr std::array names{"header.frame_id", "height", "width", "data", "is_dense"};
    const std::uint64_t chosen = 1 + random() % 31;
    std::vector<std::string> fields;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if ((chosen >> i & 1) != 0) fields.emplace_back(names[i]);
    }
    return fmt::format("{}", fmt::join(fields, ", "));
  }
};

TEST_F(Requests, SamplesInFlightDecodeUnderTheMaskThatTheyNameWhileItChanges) {
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  publisher.advertise();
  reader.subscribe("recorded");
  publisher.start_publishing(500us);
  for (int i = 0; i < 40; ++i) {
    const std::string fields = random_fields();
    reader.read(fields);
    ASSERT_TRUE(comes_true([&] { return is_served_with(publisher, reader, fields); }))
        << fields << " is asked for, " << reader_of(publisher, reader) << " served";
  }
  publisher.stop_publishing();
  EXPECT_TRUE(agree(publisher, reader));
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  EXPECT_EQ(writer_of(publisher, reader)["lost"], 0);
}

TEST_F(Requests, TheMaskOfOneReaderIsNothingToOthers) {
  Peer publisher(here(), "publisher");
  Peer changing(there(), "changing");
  Peer beside(there(), "beside");
  Peer elsewhere(here(), "elsewhere");
  publisher.advertise();
  changing.subscribe("recorded");
  beside.subscribe("height, width");
  elsewhere.subscribe("data");
  for (Peer* reader : {&changing, &beside, &elsewhere}) ASSERT_TRUE(agree(publisher, *reader));
  publisher.start_publishing();
  for (int i = 0; i < 20; ++i) {
    const std::string fields = random_fields();
    changing.read(fields);
    ASSERT_TRUE(comes_true([&] { return is_served_with(publisher, changing, fields); })) << fields;
  }
  publisher.stop_publishing();
  for (Peer* reader : {&changing, &beside, &elsewhere}) {
    EXPECT_TRUE(agree(publisher, *reader));
    EXPECT_TRUE(accounts_for_all(publisher, *reader));
    EXPECT_EQ(writer_of(publisher, *reader)["lost"], 0);
  }
  EXPECT_EQ(taken_of(publisher, beside)["masks"].size(), 1);
  EXPECT_EQ(taken_of(publisher, elsewhere)["masks"].size(), 1);
}

TEST_F(Requests, AnotherMaximumRateIsInForceSoonAndWhatItWithholdsIsNotLost) {
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  publisher.advertise();
  reader.subscribe("height, width");
  publisher.start_publishing(2ms);
  for (const double hz : {100.0, 20.0, 0.0, 50.0}) {
    reader.set_max_rate_hz(hz);
    ASSERT_TRUE(comes_true([&] {
      const json entry = reader_of(publisher, reader);
      return !entry.is_null() && entry["served"] && entry["max_rate_hz"] == hz;
    })) << hz;
    const std::uint64_t received = reader.status()["subscriber"]["received"];
    ASSERT_TRUE(comes_true([&] { return reader.status()["subscriber"]["received"] > received + 10; }));
  }
  publisher.stop_publishing();
  EXPECT_TRUE(agree(publisher, reader));
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  EXPECT_EQ(writer_of(publisher, reader)["lost"], 0);
  EXPECT_GT(writer_of(publisher, reader)["withheld"], 0);
  EXPECT_EQ(writer_of(publisher, reader)["withheld"], reader_of(publisher, reader)["withheld"]);
}

TEST_F(Requests, OldOnesAndOldAnnouncementsThatComeOnceMoreTakeNothingBack) {
  Peer echo(there(), "echo");
  echo.hear_control();
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  publisher.advertise();
  reader.subscribe("recorded");
  publisher.start_publishing();
  for (const char* fields : {"height", "data", "height, width", "width"}) {
    reader.read(fields);
    ASSERT_TRUE(comes_true([&] { return is_served_with(publisher, reader, fields); }));
  }
  const auto negotiated = [&] {
    json entry = reader_of(publisher, reader);
    entry.erase("dropped");  // may increase, because a busy machine may drop samples
    return entry;
  };
  const json before = negotiated();
  echo.repeat_control();
  ASSERT_TRUE(comes_true([&] {
    const json marker = reader_of(publisher, echo);
    return !marker.is_null() && marker["request"] == 2;
  }));
  EXPECT_EQ(negotiated(), before);
  publisher.stop_publishing();
  EXPECT_TRUE(agree(publisher, reader));
  EXPECT_TRUE(accounts_for_all(publisher, reader));
  EXPECT_EQ(writer_of(publisher, reader)["lost"], 0);
}

TEST_F(Requests, OnANetworkThatLosesRepeatsAndReordersTheLastOneIsInForce) {
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  publisher.advertise();
  reader.subscribe("recorded");
  network().set_faults({.lost = 0.2, .repeated = 0.2, .delayed = 0.3});
  publisher.start_publishing();
  std::string fields;
  for (int i = 0; i < 30; ++i) {
    fields = random_fields();
    reader.read(fields);
    if (i % 5 == 4) {
      ASSERT_TRUE(comes_true([&] { return is_served_with(publisher, reader, fields); }))
          << fields << " is asked for, " << reader_of(publisher, reader) << " served";
    }
  }
  network().set_faults({});
  EXPECT_TRUE(comes_true([&] { return is_served_with(publisher, reader, fields); }));
  publisher.stop_publishing();
  EXPECT_TRUE(agree(publisher, reader));
  EXPECT_TRUE(accounts_for_all(publisher, reader));
}

TEST_F(Requests, OnALinkThatFlapsTheLastOneIsInForce) {
  Peer publisher(here(), "publisher");
  Peer reader(there(), "reader");
  publisher.advertise();
  reader.subscribe("recorded");
  publisher.start_publishing();
  ASSERT_TRUE(comes_true([&] { return is_served(publisher, reader); }));
  std::string fields;
  for (int i = 0; i < 20; ++i) {
    there().set_plugged(i % 2 == 1);
    fields = random_fields();
    reader.read(fields);
    const std::uint64_t published = publisher.status()["publisher"]["published"];
    const std::uint64_t more = random() % 100;
    ASSERT_TRUE(comes_true([&] { return publisher.status()["publisher"]["published"] > published + more; }));
  }
  EXPECT_TRUE(comes_true([&] { return is_served_with(publisher, reader, fields); }));
  publisher.stop_publishing();
  EXPECT_TRUE(agree(publisher, reader));
  EXPECT_TRUE(accounts_for_all(publisher, reader));
}

}  // namespace
}  // namespace sft::test
