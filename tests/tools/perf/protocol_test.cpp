// Messages between the sides of a run arrive unchanged, and hostile text is no message.
#include "tools/perf/protocol.h"

#include <gtest/gtest.h>

namespace sft::perf {
namespace {

TEST(PerfProtocolTest, AnOfferArrivesAsItWas) {
  Offer offer{.session = 7, .mark = 3, .ends = true, .type = "a::msg::B", .fields = {"x, y[::2]", "*"}};
  offer.transport = TransportChoice::udp;
  offer.tcp = true;
  const auto read = offer_of(text_of(offer)).value();
  EXPECT_EQ(read.session, 7U);
  EXPECT_EQ(read.mark, 3U);
  EXPECT_TRUE(read.ends && read.tcp && !read.udp);
  EXPECT_EQ(read.fields, offer.fields);
  EXPECT_EQ(read.transport, TransportChoice::udp);
}

TEST(PerfProtocolTest, AReportArrivesAsItWas) {
  Report report{.session = 7, .side = 9, .mark = 2, .error = "no"};
  report.usage.cpu_s = 1.5;
  report.streams.push_back({.publisher = 11, .received = 12, .lost = 1, .parts = {{1, 2}, {5, 9}}});
  const auto read = report_of(text_of(report)).value();
  EXPECT_EQ(read.usage.cpu_s, 1.5);
  ASSERT_EQ(read.streams.size(), 1U);
  EXPECT_EQ(read.streams[0].parts, report.streams[0].parts);
}

TEST(PerfProtocolTest, TextOfOthersIsNothing) {
  std::string whole = text_of(Offer{.session = 7});
  for (const char* text : {"", "{", "[]", "{\"version\": 2}", "{\"version\": 1}", "7"}) {
    EXPECT_FALSE(offer_of(text)) << text;
    EXPECT_FALSE(report_of(text)) << text;
  }
  EXPECT_FALSE(report_of(whole));
  for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_FALSE(offer_of(whole.substr(0, size)));
}

}  // namespace
}  // namespace sft::perf
