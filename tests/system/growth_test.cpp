// A program that opens and closes objects again and again must not use more and more resources. After the
// first rounds, the memory, the descriptors and the threads of this process and of its peers do not grow,
// nor does the number of chunks in use. CI runs some hundred rounds, and ./run soak runs ten thousand
// rounds of most acts. A soak also prints the figure endpoint_left_bytes: the bytes per round that are
// never freed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <std_srvs/msg/SetBool_Request.hpp>
#include <std_srvs/msg/SetBool_Response.hpp>
#include <string>
#include <vector>

#include "tests/support/isolated_host.h"
#include "tests/support/pace.h"
#include "tests/support/test_seed.h"
#include "tests/system/daemon_status.h"
#include "tests/system/fixture.h"
#include "tests/system/holdings.h"
#include "tests/system/node_process.h"
#include "tools/hosts/network.h"

namespace sft::test {
namespace {

using std_srvs::msg::SetBool_Request;
using std_srvs::msg::SetBool_Response;

/// Returns the resources that the daemon holds. Only memory that it shares with no other process counts.
Holdings holdings_of_daemon(pid_t pid) {
  const std::string process = "/proc/" + std::to_string(pid);
  Holdings held{0, entries_of((process + "/fd").c_str()), entries_of((process + "/task").c_str())};
  std::ifstream status(process + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("RssAnon:")) held.bytes = std::stol(line.substr(8)) * 1024;
  return held;
}

/// Returns how many chunks of shared memory have samples.
std::int64_t chunks_in_use() {
  std::int64_t chunks = 0;
  for (const nlohmann::json& pool : daemon_status().at("usage").at("pools"))
    chunks += pool.at("in_use").get<std::int64_t>();
  return chunks;
}

/// The resources that another process holds. That process writes the members.
struct HoldingsOfOther {
  std::atomic<std::int64_t> bytes{0}, descriptors{0}, threads{0};
  std::atomic<std::uint64_t> looks{0};
  std::atomic<bool> failed{false};
  /// True once the process has its shared memory, if it uses shared memory. From then on, the resources
  /// that the process holds remain constant as long as there are no further acts.
  std::atomic<bool> settled{false};
};

/// The role of another process. It reads and writes the topics of the acts, and answers requests.
void take_part(Node& node, HoldingsOfOther& holdings, bool by_shm) {
  auto clouds = node.subscriber<PointCloud2, F::height>("clouds", [](const auto&) {}).value();
  auto source = node.publisher<PointCloud2>("source").value();
  auto replies = node.publisher<SetBool_Response>("reply", {.reliability = reliable}).value();
  const auto answer = [&](const auto& request) { replies.publish({.success = request->data()}); };
  auto requests = node.subscriber<SetBool_Request>("request", answer, {.reliability = reliable}).value();
  std::uint32_t number = 0;
  for (Pace pace(2ms);; pace.await_turn()) {
    source.publish({.height = number++});
    const Holdings now = Holdings::of_this_process();
    holdings.bytes = now.bytes;
    holdings.descriptors = now.descriptors;
    holdings.threads = now.threads;
    holdings.settled = node.status().shm_ready == by_shm;
    ++holdings.looks;
  }
}

/// The node under test. Two other hosts, and another process of its own host, use its topics.
struct Stage {
  Node node;
  Publisher<PointCloud2> publisher;
  Subscriber<PointCloud2> subscriber;
};

struct Act {
  const char* name;
  std::uint64_t rounds;  ///< the number of rounds in CI
  void (*do_once)(Stage& stage, std::uint64_t round);
};
void PrintTo(const Act& act, std::ostream* out) { *out << act.name; }

constexpr std::size_t others = 3;
/// Nodes keep the id of a withdrawn endpoint for a minute, since a slower link may still bring its
/// announcement.
constexpr std::chrono::seconds remembered_for{70};

template <class S>
void expect_matched(const S& subscriber) {
  ASSERT_TRUE(eventually([&] { return subscriber.status().writers.size() == others; }));
}

void open_subscriber(Stage& stage, std::uint64_t) {
  expect_matched(stage.node.subscriber<PointCloud2, F::width>("source").value());
}
void open_subscriber_for_a_moment(Stage& stage, std::uint64_t round) {
  (void)stage.node.subscriber<PointCloud2>("source_" + std::to_string(round)).value();
}
void open_publisher(Stage& stage, std::uint64_t round) {
  auto publisher = stage.node.publisher<PointCloud2>("clouds").value();
  ASSERT_TRUE(publisher.wait_for_subscribers(others, hang_timeout));
  publisher.publish({.height = static_cast<std::uint32_t>(round)});
}
void open_node(Stage&, std::uint64_t round) {
  Node node = Node::open({.name = "node_" + std::to_string(round)}).value();
  expect_matched(node.subscriber<PointCloud2, F::width>("source").value());
}
void call_service(Stage& stage, std::uint64_t) {
  auto replies = stage.node.subscriber<SetBool_Response>("reply", {.reliability = reliable}).value();
  auto requests = stage.node.publisher<SetBool_Request>("request", {.reliability = reliable}).value();
  ASSERT_TRUE(requests.wait_for_subscribers(others, hang_timeout));
  ASSERT_TRUE(eventually([&] {
    requests.publish({.data = true});
    const auto reply = replies.wait(10ms) ? replies.take() : decltype(replies.take()){};
    return reply && reply->success();
  }));
}
void fail_to_open(Stage& stage, std::uint64_t round) {
  EXPECT_FALSE(stage.node.subscriber<PointCloud2>("a\nb"));
  EXPECT_FALSE(stage.node.subscriber<PointCloud2>("source", {.selection = "no_field"}));
  EXPECT_FALSE(Node::open({.name = std::string(300, 'x')}));
  NodeOptions unknown{.name = "node_" + std::to_string(round)};
  unknown.cyclonedds_config = "<General><Colour>red</></>";
  EXPECT_FALSE(Node::open(unknown));
}
void refuse_sample(Stage& stage, std::uint64_t) {
  PointCloud2 cloud;
  cloud.header.frame_id = std::string("a\0b", 3);
  EXPECT_EQ(stage.publisher.publish(cloud), PublishStatus::invalid) << "a string with a NUL";
  cloud.header.frame_id.clear();
  cloud.data.resize(2 << 20);
  EXPECT_EQ(stage.publisher.publish(cloud), PublishStatus::invalid);
}
void loan(Stage& stage, std::uint64_t round) {
  auto loan = stage.publisher.loan({.height = 1}, {.data = 1 + round % 100'000});
  ASSERT_TRUE(loan);
  if (round % 2 == 0) std::move(*loan).publish();
}
void take_sample(Stage& stage, std::uint64_t) {
  ASSERT_TRUE(stage.subscriber.wait(hang_timeout));
  ASSERT_TRUE(stage.subscriber.take());
}
void change_mask(Stage& stage, std::uint64_t round) {
  const std::string end = std::to_string(1 + round);
  ASSERT_TRUE(stage.subscriber.set_selection(round % 2 == 0 ? "height" : "width, data[:" + end + "]"));
  take_sample(stage, round);
}
void change_rate(Stage& stage, std::uint64_t round) {
  ASSERT_TRUE(stage.subscriber.set_max_rate_hz(static_cast<double>(100 + round % 100)));
  take_sample(stage, round);
}
void ask(Stage& stage, std::uint64_t) {
  EXPECT_FALSE(stage.node.topics().empty());
  EXPECT_FALSE(stage.node.domain().publishers.empty());
  EXPECT_TRUE(stage.node.find_type("source", hang_timeout));
  EXPECT_FALSE(stage.node.find_type("no topic", 0s));
  EXPECT_TRUE(stage.node.ask_accounts("source"));
}
void change_links(Stage& stage, std::uint64_t) {
  const auto has_link = [&](bool is_there) {
    return eventually(
        [&] { return (stage.node.status().discovery.find("10.78.0.9") != std::string::npos) == is_there; });
  };
  ASSERT_EQ(std::system("ip address add 10.78.0.9/24 dev eth0"), 0);
  ASSERT_TRUE(has_link(true));
  ASSERT_EQ(std::system("ip address del 10.78.0.9/24 dev eth0"), 0);
  ASSERT_TRUE(has_link(false));
}

void serve_group(Stage& stage, std::uint64_t) {
  auto publisher = stage.node.publisher<PointCloud2>("clouds").value();
  ASSERT_TRUE(publisher.wait_for_subscribers(others, hang_timeout));
  const auto in_group = [](const PublisherStatus::Reader& reader) {
    return reader.multicast.starts_with("group ");
  };
  ASSERT_TRUE(eventually([&] {
    publisher.publish({.height = 1});
    return std::ranges::count_if(publisher.status().readers, in_group) == 2;
  }));
}

constexpr Act acts[] = {
    {"subscribers", 1000, open_subscriber},
    {"subscribers_for_a_moment", 300, open_subscriber_for_a_moment},
    {"publishers", 1000, open_publisher},
    {"nodes", 300, open_node},
    {"services", 300, call_service},
    {"failed_opens", 300, fail_to_open},
    {"refused_samples", 300, refuse_sample},
    {"loans", 300, loan},
    {"masks", 300, change_mask},
    {"rates", 300, change_rate},
    {"questions", 300, ask},
    {"links", 10, change_links},
    {"groups", 30, serve_group},
};

/// The maximum number of bytes that may be left: some bytes for the noise of the allocators, and for each
/// round less than the size of the smallest block of memory.
constexpr std::int64_t left_bytes_max(std::uint64_t rounds) {
  return (1 << 16) + 8 * static_cast<std::int64_t>(rounds);
}

class Growth : public testing::TestWithParam<Act> {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
    auto network = hosts::EmulatedNetwork::create(3);
    if (!network) GTEST_SKIP() << network.error().message;
    network_.emplace(std::move(*network));
    for (std::size_t i = 0; i < others; ++i) {
      const bool by_shm = i == 0;  // for one process only, because all hosts share one /dev/shm
      NodeOptions options{.name = "other"};
      options.transport = by_shm ? TransportChoice::automatic : TransportChoice::udp;
      others_.push_back(std::make_unique<Other>(
          network_->host(i), options,
          [by_shm](Node& other, HoldingsOfOther& held) { take_part(other, held, by_shm); }));
    }
    ASSERT_TRUE(network_->host(0).enter());
    Node node = Node::open({.name = "here"}).value();
    auto publisher = node.publisher<PointCloud2>("clouds", {.max_sample_bytes = 1 << 20}).value();
    auto subscriber = node.subscriber<PointCloud2>("source").value();
    stage_.emplace(Stage{std::move(node), std::move(publisher), std::move(subscriber)});
    ASSERT_TRUE(stage_->publisher.wait_for_subscribers(others, hang_timeout));
    expect_matched(stage_->subscriber);
    ASSERT_TRUE(eventually([&] {
      return stage_->node.status().shm_ready &&
             std::ranges::all_of(others_, [](const auto& other) { return other->report().settled.load(); });
    }));
    daemon_ = daemon_status().at("pid");
    ASSERT_TRUE(eventually([&] {
      return std::ranges::any_of(
          stage_->publisher.status().readers,
          [](const PublisherStatus::Reader& reader) { return reader.transport == TransportKind::shm; });
    }));
  }
  /// Returns the resources that this process holds, then those of each other process, then those of the
  /// daemon.
  std::vector<Holdings> holdings() const {
    std::vector<Holdings> all{Holdings::of_this_process()};
    for (const auto& other : others_) {
      const HoldingsOfOther& held = other->report();
      const std::uint64_t looks = held.looks;
      eventually([&] { return held.looks > looks + 1; });
      all.push_back({held.bytes, held.descriptors, held.threads});
    }
    all.push_back(holdings_of_daemon(daemon_));
    return all;
  }
  /// Waits until no node keeps ids of withdrawn endpoints any more, and then returns holdings().
  std::vector<Holdings> settled_holdings() const {
    eventually([] { return false; }, remembered_for, 1s);
    return holdings();
  }
  void repeat(std::uint64_t rounds) {
    for (std::uint64_t i = 0; i < rounds && !HasFatalFailure(); ++i)
      GetParam().do_once(*stage_, next_round_++);
  }

  /// Repeats the rounds until one repetition leaves nothing. The lists of Cyclone DDS may become longer in
  /// some repetitions, but not in all.
  void expect_nothing_left(std::uint64_t rounds) {
    std::int64_t left = left_bytes_max(rounds) + 1;
    for (int time = 0; time < 5 && left > left_bytes_max(rounds); ++time) {
      const std::vector<Holdings> before = settled_holdings();
      repeat(rounds);
      ASSERT_FALSE(HasFatalFailure());
      const std::vector<Holdings> after = settled_holdings();
      left = 0;
      for (std::size_t i = 0; i < after.size(); ++i) left = std::max(left, (after[i] - before[i]).bytes);
    }
    std::printf("endpoint_left_bytes of %s: %.1f\n", GetParam().name,
                static_cast<double>(left) / static_cast<double>(rounds));
    EXPECT_LE(left, left_bytes_max(rounds));
  }

 private:
  using Other = NodeProcessWith<HoldingsOfOther>;

  std::optional<hosts::EmulatedNetwork> network_;
  std::vector<std::unique_ptr<Other>> others_;
  std::optional<Stage> stage_;
  pid_t daemon_ = 0;
  std::uint64_t next_round_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Of, Growth, testing::ValuesIn(acts),
                         [](const auto& act) { return std::string(act.param.name); });

/// Cyclone DDS keeps free lists, which fill up within the first minutes.
constexpr std::int64_t bytes_at_first = 1 << 20;
constexpr std::int64_t bytes_each_round = 16;
/// The number of threads and descriptors that are added by the first samples, which may be sent after the
/// first rounds.
constexpr std::int64_t begun_later = 2;
/// The number of chunks that may hold samples of the other processes, which are under way or not taken by any
/// reader.
constexpr std::int64_t chunks_on_the_way = 64;

/// Returns a text that names the resources that have grown too much in that number of rounds, or an empty
/// text.
std::string growth(const std::vector<Holdings>& before, const std::vector<Holdings>& after,
                   std::uint64_t rounds) {
  const auto most = bytes_at_first + bytes_each_round * static_cast<std::int64_t>(rounds);
  std::string text;
  for (std::size_t i = 0; i < after.size(); ++i) {
    const Holdings more = after[i] - before[i];
    if (more.bytes <= most && more.descriptors <= begun_later && more.threads <= begun_later) continue;
    text += "process " + std::to_string(i) + " holds " + std::to_string(more.bytes) + " bytes, " +
            std::to_string(more.descriptors) + " descriptors and " + std::to_string(more.threads) +
            " threads more\n";
  }
  return text;
}

/// A leak grows in each repetition. The lists of Cyclone DDS, however, grow only when the number of
/// unacknowledged samples of the control topics exceeds its previous maximum, which depends on the speed of
/// the rounds.
TEST_P(Growth, EndsAfterTheFirstRounds) {
  constexpr int times = 5;
  const std::uint64_t rounds = test_rounds(GetParam().rounds);
  repeat(std::min<std::uint64_t>(rounds, 100));
  const std::int64_t chunks_before = chunks_in_use();
  std::string grown = "nothing was tried";
  for (int time = 1; time <= times && !grown.empty(); ++time) {
    const std::vector<Holdings> before = holdings();
    repeat(rounds);
    ASSERT_FALSE(HasFatalFailure());
    eventually([&] { return (grown = growth(before, holdings(), rounds)).empty(); },
               time < times ? 5s : remembered_for + 30s);
  }
  EXPECT_EQ(grown, "") << "after " << times << " times " << rounds << " rounds";
  EXPECT_TRUE(eventually([&] { return chunks_in_use() - chunks_before <= chunks_on_the_way; }))
      << chunks_in_use() << " chunks are in use, " << chunks_before << " were before";
  if (const bool is_soak = rounds > GetParam().rounds; is_soak) expect_nothing_left(rounds);
}

}  // namespace
}  // namespace sft::test
