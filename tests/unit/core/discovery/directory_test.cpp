// Nodes are notified of endpoints in any process that may match their own.
#include "core/discovery/directory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <variant>

#include "core/control/record_body.h"

namespace sft::core {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr ProcessId process_one = 1, process_two = 2;

/// Records the events of a node.
struct Listener {
  void operator()(const EndpointSeen& endpoint) {
    said.push_back("seen " + std::to_string(endpoint->id));
    seen = *endpoint;
  }
  void operator()(const EndpointDeparted& one) { said.push_back("departed " + std::to_string(one.id)); }
  void operator()(const EndpointLost& one) { said.push_back("lost " + std::to_string(one.id)); }
  void operator()(const Request& request) {
    said.push_back("request " + std::to_string(request.sequence) + " of " + std::to_string(request.reader));
  }
  void operator()(const NodeReport& report) { reports.push_back(report); }
  void operator()(const VanillaChanged&) { said.emplace_back("vanilla"); }
  void operator()(const DiscoveryNews& news) {
    std::vector<std::string>& texts = news.kind == DiscoveryNews::Kind::malformed ? refused : ignored;
    texts.insert(texts.end(), news.times, news.text);
  }

  std::vector<std::string> said, refused, ignored;
  Endpoint seen;
  std::vector<NodeReport> reports;
};

class DirectoryTest : public ::testing::Test {
 protected:
  static Endpoint endpoint(Role role, EndpointId id, const std::string& topic = "points") {
    Endpoint e;
    e.id = id;
    e.role = role;
    e.node_id = id + 1000;
    e.topic = topic;
    e.type_name = "Points";
    e.request.reader = id;
    return e;
  }
  static Request request(EndpointId reader, std::uint64_t sequence) {
    Request asked;
    asked.reader = reader;
    asked.sequence = sequence;
    asked.mask_words = {1};
    return asked;
  }
  struct Node {
    Listener listener;
    std::shared_ptr<ListeningNode> node;
  };
  std::unique_ptr<Node> open() {
    auto made = std::make_unique<Node>();
    made->node = directory.join([] {});
    return made;
  }
  void announce(const Node& node, const Endpoint& endpoint) { directory.announced(node.node, endpoint); }

  void record(ProcessId process, Role role, std::uint32_t slot, RecordKind kind,
              std::vector<std::byte> body) {
    directory.record_changed({process,
                              role,
                              {slot, kind},
                              {++revision, std::make_shared<const std::vector<std::byte>>(std::move(body))}});
  }
  void other_has(const Endpoint& endpoint, ProcessId process = process_one, std::uint32_t slot = 0) {
    record(process, endpoint.role, slot, RecordKind::announcement, to_bytes(endpoint));
  }
  void other_asks(EndpointId reader, std::uint64_t sequence, ProcessId process = process_one,
                  std::uint32_t slot = 0) {
    record(process, Role::reader, slot, RecordKind::request, to_bytes(request(reader, sequence)));
  }
  void other_withdraws(Role role, ProcessId process = process_one, std::uint32_t slot = 0) {
    directory.record_changed({process, role, {slot, RecordKind::announcement}, {++revision, nullptr}});
    directory.record_changed({process, role, {slot, RecordKind::request}, {++revision, nullptr}});
  }
  std::vector<std::string> events_of(Node& node) {
    for (const DiscoveryEvent& event : directory.take_events(*node.node)) std::visit(node.listener, event);
    return std::exchange(node.listener.said, {});
  }

  std::uint64_t revision = 0;
  std::set<std::pair<LinkId, IpAddress>> ways;
  Directory directory{[this](LinkId link, const IpAddress& ip) { return ways.contains({link, ip}); }};
};

TEST_F(DirectoryTest, TellsANodeOfWhatMayMatchItsEndpoints) {
  const auto node = open();
  announce(*node, endpoint(Role::reader, 1));
  other_has(endpoint(Role::writer, 10));
  other_has(endpoint(Role::writer, 11, "images"), process_one, 1);
  EXPECT_THAT(events_of(*node), ElementsAre("seen 10"));
  other_withdraws(Role::writer);
  EXPECT_THAT(events_of(*node), ElementsAre("departed 10"));
}

TEST_F(DirectoryTest, TellsANodeOfWhatWasThereBeforeItsEndpoint) {
  other_has(endpoint(Role::writer, 10));
  const auto node = open();
  EXPECT_THAT(events_of(*node), IsEmpty());
  announce(*node, endpoint(Role::reader, 1));
  EXPECT_THAT(events_of(*node), ElementsAre("seen 10"));
  announce(*node, endpoint(Role::reader, 2));
  EXPECT_THAT(events_of(*node), IsEmpty()) << "it knows that already";
}

TEST_F(DirectoryTest, TellsANodeOfAllOfARoleThatItAsksFor) {
  other_has(endpoint(Role::writer, 10, "images"));
  const auto node = open();
  announce(*node, endpoint(Role::reader, 1));
  directory.hear_all(node->node, Role::writer);
  other_has(endpoint(Role::writer, 11, "more"), process_one, 1);
  EXPECT_THAT(events_of(*node), ElementsAre("seen 10", "seen 11"));
  directory.withdrawn(1);
  EXPECT_THAT(events_of(*node), IsEmpty()) << "it goes on hearing them";
}

TEST_F(DirectoryTest, LetsNodesOfTheProcessHearEachOtherAndNobodyHimself) {
  const auto writer = open(), reader = open();
  announce(*writer, endpoint(Role::writer, 1));
  announce(*writer, endpoint(Role::reader, 2));
  announce(*reader, endpoint(Role::reader, 3));
  EXPECT_THAT(events_of(*writer), ElementsAre("seen 3"));
  EXPECT_THAT(events_of(*reader), ElementsAre("seen 1"));
  directory.requested(request(3, 5));
  EXPECT_THAT(events_of(*writer), ElementsAre("request 5 of 3"));
  directory.withdrawn(3);
  EXPECT_THAT(events_of(*writer), ElementsAre("departed 3"));
  EXPECT_THAT(events_of(*reader), ElementsAre("departed 1")) << "it has no more endpoint of that topic";
}

TEST_F(DirectoryTest, ShowsASubscriberOnceItsRequestIsThereToo) {
  const auto node = open();
  announce(*node, endpoint(Role::writer, 1));
  other_has(endpoint(Role::reader, 10));
  EXPECT_THAT(events_of(*node), IsEmpty());
  other_asks(10, 1);
  EXPECT_THAT(events_of(*node), ElementsAre("seen 10"));
  EXPECT_EQ(node->listener.seen.request.sequence, 1u);
  other_asks(10, 2);
  EXPECT_THAT(events_of(*node), ElementsAre("request 2 of 10"));
}

TEST_F(DirectoryTest, ShowsASubscriberWhoseRequestCameFirst) {
  const auto node = open();
  announce(*node, endpoint(Role::writer, 1));
  other_asks(10, 7);
  other_has(endpoint(Role::reader, 10));
  EXPECT_THAT(events_of(*node), ElementsAre("seen 10"));
  EXPECT_EQ(node->listener.seen.request.sequence, 7u);
}

TEST_F(DirectoryTest, TakesTheLatestRequestForANodeThatComesLate) {
  other_has(endpoint(Role::reader, 10));
  for (std::uint64_t sequence = 1; sequence < 5; ++sequence) other_asks(10, sequence);
  const auto node = open();
  announce(*node, endpoint(Role::writer, 1));
  EXPECT_THAT(events_of(*node), ElementsAre("seen 10"));
  EXPECT_EQ(node->listener.seen.request.sequence, 4u);
}

TEST_F(DirectoryTest, EndsTheEndpointWhoseSlotAnotherOneHas) {
  const auto node = open();
  announce(*node, endpoint(Role::writer, 1));
  other_has(endpoint(Role::reader, 10));
  other_asks(10, 1);
  events_of(*node);
  other_has(endpoint(Role::reader, 11));
  EXPECT_THAT(events_of(*node), ElementsAre("departed 10")) << "the request in the slot is not its own";
  other_asks(11, 1);
  EXPECT_THAT(events_of(*node), ElementsAre("seen 11"));
}

TEST_F(DirectoryTest, EndsAnEndpointThatTakesAnotherTopic) {
  const auto node = open();
  announce(*node, endpoint(Role::reader, 1));
  announce(*node, endpoint(Role::reader, 2, "images"));
  other_has(endpoint(Role::writer, 10));
  events_of(*node);
  other_has(endpoint(Role::writer, 10, "images"));
  const std::vector<std::string> said = events_of(*node);
  EXPECT_EQ(said.front(), "departed 10");
  EXPECT_EQ(said.back(), "seen 10");
  EXPECT_EQ(node->listener.seen.topic, "images");
}

TEST_F(DirectoryTest, LosesAllOfAProcessAtOnce) {
  const auto node = open();
  announce(*node, endpoint(Role::reader, 1));
  other_has(endpoint(Role::writer, 10));
  other_has(endpoint(Role::writer, 11), process_one, 1);
  other_has(endpoint(Role::writer, 12), process_two);
  events_of(*node);
  directory.peer_lost(process_one);
  EXPECT_THAT(events_of(*node), ElementsAre("lost 10", "lost 11"));
  other_has(endpoint(Role::writer, 10));
  EXPECT_THAT(events_of(*node), ElementsAre("seen 10"));
}

TEST_F(DirectoryTest, RefusesAnIdThatAnotherProcessHasUntilThatIsLost) {
  const auto node = open();
  announce(*node, endpoint(Role::reader, 1));
  other_has(endpoint(Role::writer, 10), process_one);
  events_of(*node);
  other_has(endpoint(Role::writer, 10), process_two);
  EXPECT_THAT(events_of(*node), IsEmpty());
  EXPECT_THAT(node->listener.refused, ElementsAre(HasSubstr("the id of another process")));
  other_withdraws(Role::writer, process_two);
  EXPECT_THAT(events_of(*node), IsEmpty()) << "it has nothing to withdraw";
  other_has(endpoint(Role::writer, 10), process_two);
  directory.peer_lost(process_one);
  EXPECT_THAT(events_of(*node), ElementsAre("lost 10", "seen 10"));
}

TEST_F(DirectoryTest, ShowsNoMoreOfATopicThanTheShareOfAProcess) {
  const auto node = open();
  announce(*node, endpoint(Role::reader, 1));
  for (std::uint32_t slot = 0; slot < 300; ++slot)
    other_has(endpoint(Role::writer, 1000 + slot), process_one, slot);
  EXPECT_THAT(events_of(*node), SizeIs(256));
  EXPECT_THAT(node->listener.ignored, SizeIs(300 - 256));
  other_has(endpoint(Role::writer, 10), process_two);
  EXPECT_THAT(events_of(*node), ElementsAre("seen 10")) << "another process has a share of its own";
  other_has(endpoint(Role::writer, 2000, "images"), process_one, 300);
  events_of(*node);
  EXPECT_THAT(node->listener.ignored, SizeIs(300 - 256)) << "that is another topic";
}

TEST_F(DirectoryTest, RefusesTheIdsOfItsOwnNodes) {
  const auto node = open();
  announce(*node, endpoint(Role::reader, 1));
  announce(*node, endpoint(Role::writer, 2));
  other_has(endpoint(Role::writer, 2));
  other_asks(1, 9);
  other_withdraws(Role::writer);
  EXPECT_THAT(events_of(*node), IsEmpty());
  EXPECT_THAT(node->listener.refused, SizeIs(1));
  EXPECT_THAT(directory.endpoints_of(node->node), ElementsAre(1, 2));
}

TEST_F(DirectoryTest, EndsEndpointsOfOthersWhoseIdsItsOwnNodesTake) {
  const auto node = open(), hearer = open();
  announce(*hearer, endpoint(Role::reader, 1));
  other_has(endpoint(Role::writer, 10), process_one);
  other_has(endpoint(Role::writer, 10), process_two);
  EXPECT_THAT(events_of(*hearer), ElementsAre("seen 10"));
  announce(*node, endpoint(Role::writer, 10));
  const std::vector<std::string> said = events_of(*hearer);
  ASSERT_FALSE(said.empty());
  EXPECT_EQ(said.front(), "departed 10");
  EXPECT_EQ(said.back(), "seen 10");
  directory.peer_lost(process_one);
  directory.peer_lost(process_two);
  EXPECT_THAT(events_of(*hearer), IsEmpty());
  const auto late = open();
  announce(*late, endpoint(Role::reader, 2));
  EXPECT_THAT(events_of(*late), ElementsAre("seen 10"));
  EXPECT_THAT(directory.endpoints_of(node->node), ElementsAre(10));
}

TEST_F(DirectoryTest, RefusesWhatIsMalformedOrOnTheWrongTopic) {
  const auto node = open();
  announce(*node, endpoint(Role::reader, 1));
  record(process_one, Role::writer, 0, RecordKind::announcement, {std::byte{1}});
  record(process_one, Role::writer, 1, RecordKind::announcement, to_bytes(endpoint(Role::reader, 10)));
  record(process_one, Role::reader, 2, RecordKind::request, {std::byte{1}});
  EXPECT_THAT(events_of(*node), IsEmpty());
  EXPECT_THAT(node->listener.refused, SizeIs(3));
  record(process_one, Role::writer, 1, RecordKind::announcement, to_bytes(endpoint(Role::reader, 11)));
  EXPECT_THAT(events_of(*node), IsEmpty());
  EXPECT_THAT(node->listener.refused.back(), HasSubstr("the topic of the other role"));
}

TEST_F(DirectoryTest, EndsAnEndpointWhoseNextAnnouncementIsMalformed) {
  const auto node = open();
  announce(*node, endpoint(Role::reader, 1));
  other_has(endpoint(Role::writer, 10));
  record(process_one, Role::writer, 0, RecordKind::announcement, {std::byte{1}});
  EXPECT_THAT(events_of(*node), ElementsAre("seen 10", "departed 10"));
}

TEST_F(DirectoryTest, FollowsAnEndpointToAnotherTopic) {
  const auto node = open();
  announce(*node, endpoint(Role::reader, 1));
  other_has(endpoint(Role::writer, 10));
  other_has(endpoint(Role::writer, 10, "images"));
  EXPECT_THAT(events_of(*node), ElementsAre("seen 10", "departed 10"));
}

TEST_F(DirectoryTest, LeavesOutTheAddressesOfANetworkThatIsCut) {
  const IpAddress by_lan(0x0a000001), by_radio(0x0b000001);
  ways = {{1, by_lan}, {2, by_radio}, {3, by_lan}};
  const auto node = open();
  announce(*node, endpoint(Role::reader, 1));
  Endpoint writer = endpoint(Role::writer, 10);
  writer.addresses = {{.ip = by_lan, .port = 5}, {.ip = by_radio, .port = 5}};
  other_has(writer);
  directory.paths_cut({process_one, {1}});
  EXPECT_THAT(events_of(*node), ElementsAre("seen 10", "seen 10"));
  ASSERT_THAT(node->listener.seen.addresses, SizeIs(1));
  EXPECT_EQ(node->listener.seen.addresses[0].ip, by_radio);
  directory.paths_cut({process_one, {1, 2}});
  events_of(*node);
  EXPECT_THAT(node->listener.seen.addresses, SizeIs(2)) << "process_one way at least is tried";
  directory.paths_cut({process_one, {1}, {3}});
  events_of(*node);
  EXPECT_THAT(node->listener.seen.addresses, SizeIs(2)) << "another link leads there";
  directory.paths_cut({process_one, {}});
  events_of(*node);
  EXPECT_THAT(node->listener.seen.addresses, SizeIs(2));
}

TEST_F(DirectoryTest, KeepsAllAddressesOfAProcessThatReturnsAfterOneOfItsNetworksWasCut) {
  const IpAddress by_lan(0x0a000001), by_radio(0x0b000001);
  ways = {{1, by_lan}, {2, by_radio}};
  const auto node = open();
  announce(*node, endpoint(Role::reader, 1));
  Endpoint writer = endpoint(Role::writer, 10);
  writer.addresses = {{.ip = by_lan, .port = 5}, {.ip = by_radio, .port = 5}};
  other_has(writer);
  directory.paths_cut({process_one, {1}});
  directory.peer_lost(process_one);
  other_has(writer);
  events_of(*node);
  EXPECT_THAT(node->listener.seen.addresses, SizeIs(2));
}

TEST_F(DirectoryTest, GivesReportsToNodesThatInquireAsFarAsTheProcessHasAnnouncedWhatTheyAreAbout) {
  const auto node = open(), silent = open();
  announce(*node, endpoint(Role::reader, 1));
  announce(*silent, endpoint(Role::reader, 2));
  other_has(endpoint(Role::writer, 10));
  other_has(endpoint(Role::writer, 20), process_two);
  directory.inquires(node->node, {{.topic = "points"}});
  NodeReport report;
  report.living = {10, 20, 1, 99};
  report.progress = {{10, 5, 0}, {20, 5, 0}};
  report.accounts = {{.id = {{10, 1}, Role::writer}}, {.id = {{10, 1}, Role::reader}}};
  directory.report_came(process_one, report);
  directory.report_came(process_two, {.living = {10}});
  for (const auto* const one : {&node, &silent}) events_of(**one);
  ASSERT_THAT(node->listener.reports, SizeIs(1));
  EXPECT_THAT(node->listener.reports[0].living, ElementsAre(10));
  EXPECT_THAT(node->listener.reports[0].progress, ElementsAre(Progress{10, 5, 0}));
  EXPECT_THAT(node->listener.reports[0].accounts, ElementsAre(report.accounts[0]));
  EXPECT_THAT(silent->listener.reports, IsEmpty());
}

TEST_F(DirectoryTest, GivesReportsOfANodeToOthersOfTheProcess) {
  const auto node = open(), other = open();
  announce(*node, endpoint(Role::writer, 1));
  for (const auto* const one : {&node, &other}) directory.inquires((*one)->node, {Inquiry{}});
  directory.reported(node->node, {.living = {1}});
  for (const auto* const one : {&node, &other}) events_of(**one);
  EXPECT_THAT(node->listener.reports, IsEmpty());
  EXPECT_THAT(other->listener.reports, SizeIs(1));
}

TEST_F(DirectoryTest, KnowsWhatNodesAndProcessesInquireUntilTheyDoNotOrAreLost) {
  const auto node = open();
  const Inquiry ours{.topic = "ours"}, theirs{.topic = "theirs", .wants_accounts = true};
  const auto inquired = [&] { return directory.inquiries().all; };
  const std::uint64_t made = directory.inquiries().made;
  directory.inquires(node->node, {ours});
  EXPECT_FALSE(directory.own_inquiries().empty());
  EXPECT_FALSE(directory.do_others_inquire());
  for (const Role role : both_roles) record(process_one, role, 5, RecordKind::inquiry, to_bytes(theirs));
  EXPECT_THAT(inquired(), ElementsAre(ours, theirs));
  EXPECT_NE(directory.inquiries().made, made);
  EXPECT_TRUE(directory.do_others_inquire());
  directory.record_changed({process_one, Role::writer, {5, RecordKind::inquiry}, {++revision, nullptr}});
  EXPECT_THAT(inquired(), ElementsAre(ours, theirs)) << "it is on the other topic as well";
  directory.peer_lost(process_one);
  directory.inquires(node->node, {});
  EXPECT_THAT(inquired(), IsEmpty());
  EXPECT_TRUE(directory.own_inquiries().empty());
  EXPECT_FALSE(directory.do_others_inquire());
  record(process_one, Role::reader, 5, RecordKind::inquiry, {std::byte{9}});
  EXPECT_THAT(inquired(), IsEmpty());
  events_of(*node);
  EXPECT_THAT(node->listener.refused, SizeIs(1));
}

TEST_F(DirectoryTest, WakesANodeOnceUntilItTakesItsEvents) {
  const auto node = open();
  announce(*node, endpoint(Role::reader, 1));
  directory.inquires(node->node, {Inquiry{}});
  for (std::uint32_t slot = 0; slot < 10; ++slot)
    other_has(endpoint(Role::writer, 10 + slot), process_one, slot);
  EXPECT_THAT(directory.take_woken(), ElementsAre(node->node));
  EXPECT_THAT(directory.take_woken(), IsEmpty());
  events_of(*node);
  other_withdraws(Role::writer);
  EXPECT_THAT(directory.take_woken(), ElementsAre(node->node));
  events_of(*node);
  directory.report_came(process_one, {.progress = {{11, 5, 0}}});
  EXPECT_THAT(directory.take_woken(), IsEmpty()) << "such a report has time";
  for (int i = 0; i < 100; ++i) directory.report_came(process_one, {.progress = {{11, 5, 0}}});
  EXPECT_THAT(directory.take_woken(), ElementsAre(node->node)) << "so that they do not use up memory";
  directory.report_came(process_one, {.living = {11}});
  events_of(*node);
  directory.report_came(process_one, {.living = {11}});
  EXPECT_THAT(directory.take_woken(), ElementsAre(node->node));
}

TEST_F(DirectoryTest, NamesAllPublishersOfAType) {
  const auto node = open();
  announce(*node, endpoint(Role::writer, 1, "mine"));
  other_has(endpoint(Role::writer, 10, "theirs"));
  other_has(endpoint(Role::reader, 11, "theirs"), process_one, 1);
  EXPECT_THAT(directory.publishers_of("Points"), SizeIs(2));
  EXPECT_THAT(directory.publishers_of("Images"), IsEmpty());
}

TEST_F(DirectoryTest, TellsANodeThatHasClosedNothingMore) {
  const auto node = open();
  announce(*node, endpoint(Role::reader, 1));
  directory.withdrawn(1);
  directory.leave(node->node);
  other_has(endpoint(Role::writer, 10));
  directory.vanilla_changed();
  EXPECT_THAT(events_of(*node), IsEmpty());
}

}  // namespace
}  // namespace sft::core
