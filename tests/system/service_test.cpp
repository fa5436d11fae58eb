// Services. Each call is answered, or ends with an error that gives the reason, even if clients and servers
// start and end at any time.
#include <gmock/gmock.h>

#include <algorithm>
#include <future>
#include <latch>
#include <memory>
#include <optional>
#include <service_msgs/srv/Add.hpp>
#include <service_msgs/srv/Image.hpp>
#include <std_srvs/srv/SetBool.hpp>
#include <thread>
#include <vector>

#include "tests/support/test_seed.h"
#include "tests/system/fixture.h"
#include "tests/system/node_process.h"

namespace sft::test {
namespace {

using service_msgs::srv::Add;
using ::testing::HasSubstr;

/// Blocks a handler until the test opens the gate.
class Gate {
 public:
  void open() { is_open_ = true; }
  void pass() const {
    EXPECT_TRUE(eventually([&] { return is_open_.load(); }));
  }

 private:
  std::atomic<bool> is_open_{false};
};

class ServiceTest : public PubSubTest {
 protected:
  static Service<Add> serve(Node& node, Service<Add>::Handler handler) {
    return Service<Add>::open(node, "sum", std::move(handler)).value();
  }
  /// Opens a server that counts its runs.
  Service<Add> serve(Node& node) {
    return serve(node, [this](const Add::Request& request) {
      ++runs;
      return sum(request);
    });
  }
  static Add::Response sum(const Add::Request& request) {
    return {.sum = request.a + request.b, .data = std::vector<std::uint8_t>(request.bytes, 7)};
  }
  static Client<Add> client_of(Node& node) { return Client<Add>::open(node, "sum").value(); }

  /// Calls the service. Returns the sum as text, or the text of the error.
  static std::string answer(Client<Add>& client, std::int64_t a, std::int64_t b,
                            std::chrono::nanoseconds timeout = hang_timeout) {
    const auto response = client.call({.a = a, .b = b}, timeout);
    return response ? std::to_string(response->sum) : response.error().message;
  }

  static NodeSnapshot::Publisher publisher(const Node& node, const std::string& topic) {
    for (const auto& each : node.snapshot().publishers)
      if (each.topic == topic) return each;
    return {};
  }
  /// Returns the server's counts of the replies to the client of another node.
  static PublisherStatus::Reader replies_to(const Node& server, const std::string& node) {
    for (const auto& reader : publisher(server, "sum/reply").readers)
      if (reader.node == node) return reader;
    return {};
  }

  std::atomic<int> runs{0};
};

TEST_P(ServiceTest, AClientGetsTheAnswerToEachOfItsCalls) {
  Node a = open("server");
  Node b = open("client");
  const auto server = serve(a);
  auto client = client_of(b);
  EXPECT_EQ(answer(client, 1, 2), "3");
  EXPECT_TRUE(client.is_available());
  for (int i = 0; i < 20; ++i) EXPECT_EQ(answer(client, i, 100), std::to_string(i + 100));
  EXPECT_EQ(runs, 21);
}

TEST_P(ServiceTest, ServerAndClientMayShareANode) {
  Node node = open("both");
  const auto server = serve(node);
  auto client = client_of(node);
  EXPECT_EQ(answer(client, 1, 2), "3");
}

TEST_P(ServiceTest, AServiceOfThePackagesOfRos2Works) {
  using std_srvs::srv::SetBool;
  Node a = open("server");
  Node b = open("client");
  const auto server = Service<SetBool>::open(a, "lights", [](const SetBool::Request& request) {
                        return SetBool::Response{.success = true, .message = request.data ? "on" : "off"};
                      }).value();
  auto client = Client<SetBool>::open(b, "lights").value();
  EXPECT_EQ(client.call({.data = true}, hang_timeout).value().message, "on");
}

TEST_P(ServiceTest, ACallWaitsForAServerThatComesLater) {
  Node b = open("client");
  auto client = client_of(b);
  EXPECT_FALSE(client.is_available());
  auto waiting = std::async(std::launch::async, [&] { return answer(client, 1, 2); });
  Node a = open("server");
  const auto server = serve(a);
  EXPECT_EQ(waiting.get(), "3");
  EXPECT_EQ(runs, 1);
}

TEST_P(ServiceTest, TenClientsThatBeginTogetherWithTheServerGetTheirOwnAnswers) {
  constexpr std::int64_t clients = 10, calls = 5;
  std::vector<Node> nodes;
  for (const char* name : {"client_1", "client_2", "client_3"}) nodes.push_back(open(name));
  Node a = open("server");
  std::latch start(clients + 1);
  std::vector<std::thread> threads;
  for (std::int64_t i = 0; i < clients; ++i) {
    threads.emplace_back([&, i] {
      start.arrive_and_wait();
      auto client = client_of(nodes[static_cast<std::size_t>(i) % nodes.size()]);
      for (std::int64_t k = 0; k < calls; ++k)
        EXPECT_EQ(answer(client, 1000 * i, k), std::to_string(1000 * i + k));
    });
  }
  start.arrive_and_wait();
  const auto server = serve(a);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(runs, clients * calls);
}

// In CI each client makes a few calls, and the server restarts once. In a soak all clients together make ten
// thousand calls, and the server restarts 34 times.
TEST_P(ServiceTest, SixtyFourClientsGetTheirOwnAnswersWhileTheServerRestarts) {
  constexpr std::int64_t clients = 64;
  const auto calls = static_cast<std::int64_t>(test_rounds(5)), restarts = calls / 5;
  std::vector<Node> nodes;
  for (int i = 1; i <= 8; ++i) nodes.push_back(open("client_" + std::to_string(i)));
  std::optional<Node> host(open("server"));
  std::optional<Service<Add>> server(serve(*host));
  std::atomic<std::int64_t> ended{0}, unanswered{0};
  const auto call = [&](std::int64_t which) {
    auto client = client_of(nodes[static_cast<std::size_t>(which) % nodes.size()]);
    for (std::int64_t k = 0; k < calls; ++k, ++ended) {
      const std::string text = answer(client, 1000 * which, k);
      if (text == std::to_string(1000 * which + k)) continue;
      EXPECT_THAT(text, HasSubstr("has gone; whether it has carried out the call is not known"));
      ++unanswered;
    }
  };
  std::vector<std::thread> threads;
  for (std::int64_t i = 0; i < clients; ++i) threads.emplace_back(call, i);
  for (std::int64_t i = 1; i <= restarts; ++i) {
    EXPECT_TRUE(eventually([&] { return ended >= i * clients * calls / (restarts + 1); }));
    server.reset();
    host.reset();
    host.emplace(open("server"));
    server.emplace(serve(*host));
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(ended, clients * calls);
  EXPECT_LE(unanswered, clients * restarts) << "only calls that were under way when the server went";
  EXPECT_GE(runs, ended - unanswered);
}

TEST_P(ServiceTest, ACallToNobodyEndsWithTheReasonAndIsNotMadeLater) {
  Node a = open("server");
  Node b = open("client");
  auto client = client_of(b);
  EXPECT_EQ(answer(client, 1, 2, 50ms), "service 'sum': no server was there within 50 ms");
  for (int i = 0; i < 1000; ++i)
    EXPECT_EQ(answer(client, 1, 2, 0ms), "service 'sum': no server was there within 0 s");
  const auto server = serve(a);
  EXPECT_EQ(answer(client, 3, 4), "7");
  EXPECT_EQ(runs, 1);
}

TEST_P(ServiceTest, ARepeatedCallIsCarriedOutOnce) {
  Node a = open("server");
  Node b = open("client");
  const auto server = serve(a, [&](const Add::Request& request) {
    ++runs;
    EXPECT_TRUE(eventually([&] { return publisher(b, "sum/call").published >= 3; })) << "it is repeated";
    return sum(request);
  });
  auto client = client_of(b);
  EXPECT_EQ(answer(client, 1, 2), "3");
  EXPECT_EQ(answer(client, 3, 4), "7");
  EXPECT_EQ(runs, 2);
}

TEST_P(ServiceTest, ALateAnswerBelongsToNoLaterCall) {
  Node a = open("server");
  Node b = open("client");
  Gate late;
  const auto server = serve(a, [&](const Add::Request& request) {
    if (request.a == 1) late.pass();
    ++runs;
    return sum(request);
  });
  auto client = client_of(b);
  ASSERT_EQ(answer(client, 0, 0), "0");
  EXPECT_EQ(answer(client, 1, 2, 50ms),
            "service 'sum': the server on node 'server' did not answer within 50 ms");
  late.open();
  ASSERT_TRUE(eventually([&] { return replies_to(a, "client").sent >= 2; }));
  EXPECT_EQ(answer(client, 3, 4), "7");
  EXPECT_EQ(runs, 3);
}

TEST_P(ServiceTest, AnAnswerGoesToItsAskerOnly) {
  Node a = open("server");
  Node b = open("client");
  Node c = open("other");
  Node d = open("newcomer");
  const auto server = serve(a);
  auto client = client_of(b);
  auto other = client_of(c);
  EXPECT_EQ(answer(other, 1, 2), "3");
  const auto newcomer = client_of(d);
  EXPECT_EQ(answer(client, 1, 2), "3");
  ASSERT_TRUE(eventually([&] { return replies_to(a, "newcomer").served; }));
  const auto before = replies_to(a, "other");
  const auto response = client.call({.a = 3, .b = 4, .bytes = 8'000'000}, hang_timeout);
  ASSERT_TRUE(response) << response.error().message;
  EXPECT_EQ(response->data, std::vector<std::uint8_t>(8'000'000, 7));
  ASSERT_TRUE(eventually([&] { return replies_to(a, "other").withheld > before.withheld; }));
  EXPECT_EQ(replies_to(a, "other").sent, before.sent);
  EXPECT_EQ(replies_to(a, "newcomer").sent, 0U);
  for (const char* node : {"other", "newcomer"}) EXPECT_LT(replies_to(a, node).bytes_sent, 1000U) << node;
}

TEST_P(ServiceTest, TwoServersOfOneNameAreNamed) {
  Node a = open("left");
  Node b = open("client");
  auto left = std::optional(serve(a));
  auto client = client_of(b);
  ASSERT_EQ(answer(client, 1, 2), "3");
  Node c = open("right");
  const auto right = serve(c);
  ASSERT_TRUE(eventually([&] { return !client.is_available(); }));
  const std::string text = answer(client, 1, 2, 50ms);
  EXPECT_THAT(text, HasSubstr("there is more than one server, on the nodes '"));
  EXPECT_THAT(text, HasSubstr("'left'"));
  EXPECT_THAT(text, HasSubstr("'right'"));
  EXPECT_EQ(runs, 1) << "none of the two was called";
  left.reset();
  EXPECT_EQ(answer(client, 3, 4), "7");
}

TEST_P(ServiceTest, ACallThatIsUnderWayIsNotCarriedOutByASecondServer) {
  Node a = open("left");
  Node b = open("client");
  Gate late;
  const auto left = serve(a, [&](const Add::Request& request) {
    ++runs;
    late.pass();
    return sum(request);
  });
  auto client = client_of(b);
  auto waiting = std::async(std::launch::async, [&] { return answer(client, 1, 2); });
  ASSERT_TRUE(eventually([&] { return runs == 1; }));
  Node c = open("right");
  auto right = std::optional(serve(c));
  EXPECT_TRUE(eventually([&] { return c.snapshot().subscribers.at(0).received > 0; }))
      << "it hears repetitions";
  right.reset();
  EXPECT_EQ(runs, 1);
  late.open();
  EXPECT_EQ(waiting.get(), "3");
}

TEST_P(ServiceTest, AServerThatIsKilledEndsTheCallAndItsSuccessorAnswersTheNext) {
  warnings_expected = true;  // for warnings about the killed process
  SharedWithChildren<std::atomic<bool>> is_called;
  const pid_t doomed = fork();
  if (doomed == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    Node node = open("doomed");
    const auto server = serve(node, [&](const Add::Request& request) {
      *is_called = true;
      for (;;) pause();
      return sum(request);
    });
    for (;;) pause();
  }
  Node b = open("client");
  auto client = client_of(b);
  auto waiting = std::async(std::launch::async, [&] { return answer(client, 1, 2); });
  EXPECT_TRUE(eventually([&] { return is_called->load(); }));
  kill(doomed, SIGKILL);
  waitpid(doomed, nullptr, 0);
  EXPECT_THAT(waiting.get(), HasSubstr("service 'sum': its server, on node 'doomed', has gone"));
  const auto successor = serve(b);
  EXPECT_EQ(answer(client, 3, 4), "7");
}

TEST_P(ServiceTest, AClientGetsTheReasonForWhichTheServerRefuses) {
  Node a = open("server");
  const auto server = serve(a, [](const Add::Request& request) -> Result<Add::Response> {
    if (request.a < 0) return fail(Errc::invalid_argument, "a is negative");
    return sum(request);
  });
  auto client = client_of(a);
  EXPECT_EQ(answer(client, -1, 0), "service 'sum': the server refuses: a is negative");
  EXPECT_EQ(answer(client, 1, 0), "1");
}

TEST_P(ServiceTest, AResponseThatIsTooLargeForTheStackIsFilledIn) {
  using service_msgs::srv::Image;
  Node robot = open("robot"), station = open("station");
  const auto expose = [](const Image::Request& request, Image::Response& response) -> Result<void> {
    if (request.value == 0) return fail(Errc::invalid_argument, "it is dark");
    response.data.fill(request.value);
    return {};
  };
  const auto server = Service<Image>::open(robot, "image", expose).value();
  auto client = Client<Image>::open(station, "image").value();
  const auto response = std::make_unique<Image::Response>();
  const Result<void> done = client.call({.value = 7}, *response, hang_timeout);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_TRUE(std::ranges::all_of(response->data, [](std::uint8_t byte) { return byte == 7; }));
  EXPECT_THAT(client.call({.value = 0}, *response, hang_timeout).error().message,
              HasSubstr("the server refuses: it is dark"));
}

TEST_P(ServiceTest, AServerWithoutAHandlerIsNotOpened) {
  Node node = open("server");
  const Result<Service<Add>> servers[] = {
      Service<Add>::open(node, "sum", nullptr), Service<Add>::open(node, "sum", {}),
      Service<Add>::open(node, "sum", Service<Add>::Handler()),
      Service<Add>::open(node, "sum", Service<Add>::FillingHandler(), {})};
  for (const Result<Service<Add>>& server : servers)
    EXPECT_EQ(server.error().message, "service 'sum': no handler");
}

TEST_P(ServiceTest, AResponseOrARequestThatIsTooLargeIsNamed) {
  warnings_expected = true;
  Node a = open("server");
  const auto server = Service<Add>::open(a, "sum", &sum, {.max_sample_bytes = 10'000}).value();
  auto client = client_of(a);
  const auto response = client.call({.bytes = 20'000}, hang_timeout);
  ASSERT_FALSE(response);
  EXPECT_THAT(response.error().message, HasSubstr("service 'sum': the response cannot be sent: "));
  EXPECT_EQ(answer(client, 1, 2), "3");
}

TEST_P(ServiceTest, ACallInACallbackForSamplesIsRefused) {
  Node a = open("server");
  const auto server = serve(a);
  auto client = client_of(a);
  std::promise<std::string> said;
  const auto points = a.subscriber<PointCloud2>("points", [&](const Sample<PointCloud2>&) {
                         said.set_value(answer(client, 1, 2));
                       }).value();
  auto lidar = a.publisher<PointCloud2>("points").value();
  expect_served(lidar, 1);
  lidar.publish(cloud(1));
  EXPECT_THAT(said.get_future().get(), HasSubstr("a call in a callback for samples would wait for itself"));
  EXPECT_EQ(runs, 0);
}

TEST_P(ServiceTest, ASecondThreadThatCallsWithAClientMeanwhileIsRefused) {
  Node a = open("server");
  Node b = open("client");
  Gate gate;
  std::atomic<bool> asked{false};
  const auto server = serve(a, [&](const Add::Request& request) {
    asked = true;
    gate.pass();
    return sum(request);
  });
  auto client = client_of(b);
  auto first = std::async(std::launch::async, [&] { return answer(client, 1, 2); });
  EXPECT_TRUE(eventually([&] { return asked.load(); }));
  EXPECT_THAT(answer(client, 3, 4), HasSubstr("two threads call with one client at the same time"));
  gate.open();
  EXPECT_EQ(first.get(), "3");
  EXPECT_EQ(answer(client, 5, 6), "11");
}

TEST_P(ServiceTest, AProgramWithoutTheTypeCallsByTopicsAlone) {
  Node a = open("server");
  Node b = open("tool");
  const auto server = serve(a);
  auto calls =
      b.publisher("sum/call", b.find_type("sum/call", hang_timeout).value(), {.reliability = reliable})
          .value();
  auto replies = b.subscriber("sum/reply", b.find_type("sum/reply", hang_timeout).value(), "*",
                              {.reliability = reliable})
                     .value();
  ASSERT_TRUE(calls.wait_for_subscribers(1, hang_timeout));
  ASSERT_TRUE(eventually([&] { return replies_to(a, "tool").served; }));
  const auto next_sum = [&]() -> std::int64_t {
    if (!replies.wait(hang_timeout)) return -1;
    const auto sample = replies.take();
    return sample.view()["response"]["sum"].as<std::int64_t>().value();
  };
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(calls.publish_json(R"({"request": {"a": 1, "b": 2}})"));
  EXPECT_EQ(next_sum(), 3);
  EXPECT_EQ(next_sum(), 3) << "calls without a client are no repetitions";
}

INSTANTIATE_TEST_SUITE_P(Ways, ServiceTest, ::testing::Values(Way::shm, Way::udp), way_name);

}  // namespace
}  // namespace sft::test
