// A server that computes the length of a path, and a client that calls it. Here both are in one program, but
// they could run on two hosts as well.
#include <sft/sft.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <route_msgs/srv/Measure.hpp>

using namespace std::chrono_literals;
using route_msgs::srv::Measure;

/// Returns a response, or an error whose message is sent to the client.
sft::Result<Measure::Response> measure(const Measure::Request& request) {
  if (request.points.size() < 2)
    return sft::fail(sft::Errc::invalid_argument, "a path has two points at least");
  Measure::Response response;
  for (std::size_t i = 1; i < request.points.size(); ++i) {
    response.length += std::hypot(request.points[i].x - request.points[i - 1].x,
                                  request.points[i].y - request.points[i - 1].y);
  }
  return response;
}

int main() {
  auto node = sft::Node::open({.name = "service"});
  if (!node) return std::fprintf(stderr, "%s\n", node.error().message.c_str()), 1;
  auto client = sft::Client<Measure>::open(*node, "measure_path");
  if (!client) return std::fprintf(stderr, "%s\n", client.error().message.c_str()), 1;

  Measure::Request path{.points = {{.x = 0, .y = 0}, {.x = 3, .y = 4}, {.x = 3, .y = 6}}};
  const auto too_early = client->call(path, 100ms);  // fails after 100 ms: there is no server yet
  std::printf("%s\n", too_early ? "there is a server" : too_early.error().message.c_str());

  auto server = sft::Service<Measure>::open(*node, "measure_path", &measure);
  if (!server) return std::fprintf(stderr, "%s\n", server.error().message.c_str()), 1;
  const auto response = client->call(path, 5s);
  if (!response) return std::fprintf(stderr, "%s\n", response.error().message.c_str()), 1;
  std::printf("the path is %.1f m long\n", response->length);

  path.points.resize(1);
  const auto refused = client->call(path, 5s);
  std::printf("%s\n", refused ? "it has a length" : refused.error().message.c_str());
}
