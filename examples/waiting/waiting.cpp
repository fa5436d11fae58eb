// An event loop in the program itself: one thread waits for samples and for a timer, without callbacks or
// locks.
#include <sft/sft.h>

#include <poll.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <geometry_msgs/msg/Twist.hpp>

using geometry_msgs::msg::Twist;
using F = Twist::Field;

int main() {
  auto node = sft::Node::open({.name = "waiting"});
  if (!node) return std::fprintf(stderr, "%s\n", node.error().message.c_str()), 1;
  auto publisher = node->publisher<Twist>("cmd_vel").value();
  auto commands = node->subscriber<Twist, F::linear.x>("cmd_vel", {.pollable = true}).value();

  // A command that is published before both sides have found each other would not be received.
  if (!publisher.wait_for_subscribers(1, std::chrono::seconds(5)))
    return std::puts("no subscriber for 5 s"), 1;

  const int timer = timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC);
  const itimerspec every_50_ms{.it_interval = {0, 50'000'000}, .it_value = {0, 50'000'000}};
  timerfd_settime(timer, 0, &every_50_ms, nullptr);

  // Other descriptors of the program could be watched here, too: sockets, devices, the standard input.
  pollfd watched[] = {{.fd = commands.file_descriptor(), .events = POLLIN, .revents = 0},
                      {.fd = timer, .events = POLLIN, .revents = 0}};
  Twist command;
  for (int received = 0; received < 10;) {
    if (poll(watched, 2, 5000) <= 0) return std::puts("nothing happened for 5 s"), 1;
    if (watched[0].revents != 0) {
      while (const auto sample = commands.take()) {  // until the descriptor is not readable any more
        std::printf("command %d: %.1f m/s\n", ++received, sample->linear().x());
      }
    }
    if (watched[1].revents != 0) {
      std::uint64_t expirations = 0;
      if (read(timer, &expirations, sizeof expirations) < 0) return 1;
      command.linear.x += 0.1;
      publisher.publish(command);
    }
  }
  close(timer);
}
