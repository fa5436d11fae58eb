// The bodies of records are decoded as they were encoded, and any other bytes are refused.
#include "core/control/record_body.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "core/names/names.h"
#include "tests/support/test_seed.h"

namespace sft::core {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

Endpoint full_endpoint() {
  Endpoint e;
  e.id = 11;
  e.role = Role::reader;
  e.node_id = 12;
  e.node = "camera";
  e.topic = "points";
  e.given_topic = "/points";
  e.type_name = "sensor_msgs/PointCloud2";
  e.type_hash = 13;
  e.type_description = {std::byte{1}, std::byte{2}};
  e.host.bytes[31] = 14;
  e.memory_failure = "no daemon";
  e.network = 15;
  e.may_use_memory = e.may_use_network = e.waits = true;
  e.addresses = {{.ip = IpAddress(0x0a000001), .port = 16, .receive_buffer_bytes = 17, .wireless = true}};
  e.doorbell = {.page = 18, .slot = 19};
  e.max_sample_bytes = 20;
  e.qos = {.reliability = Reliability::reliable,
           .durability = Durability::transient_local,
           .deadline = std::chrono::nanoseconds(21),
           .liveliness = Liveliness::manual_by_topic,
           .liveliness_lease = std::chrono::nanoseconds(22),
           .lifespan = std::chrono::nanoseconds(23),
           .history_depth = 24};
  e.request.reader = 11;
  return e;
}

Request full_request() {
  return {.reader = 11,
          .sequence = 2,
          .mask_words = {3, ~std::uint64_t{0}},
          .min_period_us = 4,
          .parts = {std::byte{5}},
          .listening = {6},
          .attached = {7, 8},
          .begun = {9}};
}

Result<Endpoint> changed(const std::function<void(Endpoint&)>& change) {
  Endpoint endpoint = full_endpoint();
  change(endpoint);
  return endpoint_in(to_bytes(endpoint));
}

TEST(RecordBodyTest, OfAnEndpointComesAsItWasWritten) {
  const Result<Endpoint> come = endpoint_in(to_bytes(full_endpoint()));
  ASSERT_TRUE(come) << come.error().message;
  EXPECT_EQ(*come, full_endpoint());
}

TEST(RecordBodyTest, OfARequestAndAnInquiryComeAsTheyWereWritten) {
  EXPECT_EQ(request_in(to_bytes(full_request())).value(), full_request());
  const Inquiry inquiry{.topic = "points", .wants_accounts = true};
  EXPECT_EQ(inquiry_in(to_bytes(inquiry)).value(), inquiry);
  EXPECT_EQ(inquiry_in(to_bytes(Inquiry{})).value(), Inquiry{});
}

NodeReport full_report() {
  return {.living = {1, 2},
          .progress = {{3, 4, 5}},
          .accounts = {{.id = {{6, 7}, Role::writer},
                        .by_writer = {.sent = 8,
                                      .withheld = 9,
                                      .dropped = 10,
                                      .retained = 11,
                                      .bytes_sent = 12,
                                      .bytes_saved = 13,
                                      .diverted = 16,
                                      .too_large_bytes = 17,
                                      .chunk_bytes = 18}},
                       {.id = {{6, 7}, Role::reader}, .by_reader = {.received = 14, .lost = 15}}}};
}

TEST(RecordBodyTest, OfAReportComesAsItWasWrittenWithoutTheCountsOfTheOtherSide) {
  NodeReport report = full_report();
  EXPECT_EQ(report_in(to_bytes(report)).value(), full_report());
  report.accounts[0].by_reader.lost = 99;
  report.accounts[1].by_writer.sent = 99;
  EXPECT_EQ(report_in(to_bytes(report)).value(), full_report());
  EXPECT_EQ(report_in(to_bytes(NodeReport{})).value(), NodeReport{});
}

TEST(RecordBodyTest, OfAReportHasRoomForAllThatMayBeInIt) {
  NodeReport report = full_report();
  report.living.resize(5000);
  report.progress.resize(5000, report.progress[0]);
  report.accounts.resize(5000, report.accounts[0]);
  const std::vector<std::byte> bytes = to_bytes(report);
  EXPECT_LE(bytes.size(), report_bytes_max);
  const NodeReport come = report_in(bytes).value();
  EXPECT_THAT(come.living, SizeIs(living_max));
  EXPECT_THAT(come.progress, SizeIs(progress_max));
  EXPECT_THAT(come.accounts, SizeIs(accounts_max));
}

TEST(RecordBodyTest, OfAReportIsRefusedWithAnAccountOfNeitherSide) {
  NodeReport report = full_report();
  report.accounts[1].id.said_by = static_cast<Role>(2);
  EXPECT_FALSE(report_in(to_bytes(report)));
}

TEST(RecordBodyTest, LeavesTheRequestOutOfAnEndpoint) {
  const Result<Endpoint> come = changed([](Endpoint& e) { e.request = full_request(); });
  EXPECT_EQ(come.value(), full_endpoint());
}

template <class Read>
void expect_every_cut_refused(const std::vector<std::byte>& whole, Read read) {
  std::vector<std::byte> bytes = whole;
  bytes.push_back(std::byte{0});
  EXPECT_FALSE(read(bytes)) << "one octet too many";
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(read(std::span(whole).first(size))) << size << " octets";
}

TEST(RecordBodyTest, IsRefusedWhereverItIsCut) {
  expect_every_cut_refused(to_bytes(full_endpoint()), &endpoint_in);
  expect_every_cut_refused(to_bytes(full_request()), &request_in);
  expect_every_cut_refused(to_bytes(Inquiry{.topic = "points"}), &inquiry_in);
  expect_every_cut_refused(to_bytes(full_report()), &report_in);
}

TEST(RecordBodyTest, IsRefusedWithTheNameOfWhatIsWrong) {
  const auto fault = [](const std::function<void(Endpoint&)>& change) {
    const Result<Endpoint> come = changed(change);
    return come ? std::string() : come.error().message;
  };
  EXPECT_THAT(fault([](Endpoint& e) { e.id = 0; }), HasSubstr("without id"));
  EXPECT_THAT(fault([](Endpoint& e) { e.role = static_cast<Role>(2); }), HasSubstr("without id or role"));
  EXPECT_THAT(fault([](Endpoint& e) { e.topic = "a\x1b[2Jb"; }), HasSubstr("whose topic 'a"));
  EXPECT_THAT(fault([](Endpoint& e) { e.topic = ""; }), HasSubstr("whose topic"));
  EXPECT_THAT(fault([](Endpoint& e) { e.given_topic = "\n"; }), HasSubstr("program's topic"));
  EXPECT_THAT(fault([](Endpoint& e) { e.node = "\x7f"; }), HasSubstr("node name"));
  EXPECT_THAT(fault([](Endpoint& e) { e.type_name = ""; }), HasSubstr("type name"));
  EXPECT_THAT(fault([](Endpoint& e) { e.qos.durability = static_cast<Durability>(9); }),
              HasSubstr("quality of service"));
  EXPECT_THAT(fault([](Endpoint& e) { e.qos.deadline = std::chrono::nanoseconds(-1); }),
              HasSubstr("out of bounds"));
}

TEST(RecordBodyTest, MayLackTheNamesThatAProgramMayLeaveOut) {
  EXPECT_TRUE(changed([](Endpoint& e) { e.node = e.given_topic = e.memory_failure = ""; }));
}

TEST(RecordBodyTest, LeavesOutWhatIsOfNoUseToOthers) {
  const Result<Endpoint> come = changed([](Endpoint& e) {
    e.topic = "/points";
    e.memory_failure = "\x1b";
    e.addresses.push_back({.ip = IpAddress(0xe0000001), .port = 5});
    e.addresses.push_back({.ip = IpAddress(0x0a000002), .port = 0});
    e.addresses.push_back({.ip = {}, .port = 5});
  });
  EXPECT_EQ(come.value().topic, "points");
  EXPECT_EQ(come.value().memory_failure, "");
  EXPECT_THAT(come.value().addresses, SizeIs(1));
}

TEST(RecordBodyTest, CutsWhatIsLongerThanItsBounds) {
  const Result<Endpoint> come = changed([](Endpoint& e) {
    e.memory_failure = std::string(1000, 'x');
    e.addresses.assign(100, e.addresses[0]);
    e.type_description.assign(type_description_bytes_max + 1, std::byte{1});
  });
  EXPECT_THAT(come.value().memory_failure, SizeIs(name_bytes_max));
  EXPECT_THAT(come.value().addresses, SizeIs(addresses_max));
  EXPECT_THAT(come.value().type_description, IsEmpty()) << "half of a description is none";
  Request request = full_request();
  request.parts.assign(wants_bytes_max + 1, std::byte{1});
  request.listening.assign(writers_per_reader_max + 1, 1);
  const Result<Request> asked = request_in(to_bytes(request));
  EXPECT_THAT(asked.value().parts, IsEmpty());
  EXPECT_THAT(asked.value().listening, SizeIs(writers_per_reader_max));
}

TEST(RecordBodyTest, HasNoMoreBytesThanARecordMayHave) {
  Endpoint endpoint = full_endpoint();
  endpoint.node = endpoint.topic = endpoint.type_name = std::string(name_bytes_max, 'x');
  endpoint.addresses.assign(addresses_max, endpoint.addresses[0]);
  endpoint.type_description.assign(type_description_bytes_max, std::byte{1});
  EXPECT_LE(to_bytes(endpoint).size(), record_bytes_max);
  Request request = full_request();
  request.mask_words.assign(mask_words_max, 1);
  request.parts.assign(wants_bytes_max, std::byte{1});
  request.listening.assign(writers_per_reader_max, 1);
  request.attached = request.begun = request.listening;
  EXPECT_LE(to_bytes(request).size(), record_bytes_max);
}

TEST(RecordBodyTest, OfSequencesThatNoReaderComesToIsRefused) {
  Request request = full_request();
  request.sequence = request_sequence_max;
  EXPECT_TRUE(request_in(to_bytes(request)));
  ++request.sequence;
  EXPECT_FALSE(request_in(to_bytes(request)));
  request = full_request();
  request.reader = 0;
  EXPECT_FALSE(request_in(to_bytes(request)));
}

class RandomBodyTest : public test::RandomTest {};

/// Sanitizers and assertions check that decoding does not read beyond the end of the octets.
TEST_F(RandomBodyTest, WithAnyOctetsIsReadOrRefused) {
  const std::vector<std::byte> endpoint = to_bytes(full_endpoint()), request = to_bytes(full_request());
  for (std::uint64_t round = 0; round < test::test_rounds(20'000); ++round) {
    std::vector<std::byte> bytes = round % 2 == 0 ? endpoint : request;
    for (std::uint64_t i = 0; i <= random() % 8; ++i)
      bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    const Result<Endpoint> come = endpoint_in(bytes);
    EXPECT_LE(come ? come->addresses.size() : 0, addresses_max);
    const Result<Request> asked = request_in(bytes);
    EXPECT_LE(asked ? asked->listening.size() : 0, writers_per_reader_max);
    (void)inquiry_in(bytes);
  }
}

}  // namespace
}  // namespace sft::core
