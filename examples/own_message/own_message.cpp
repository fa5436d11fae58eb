// Publishes a message that the .msg files of this folder define. The subscriber requests only one member of
// each element.
#include <sft/sft.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <harvest_msgs/msg/Basket.hpp>
#include <string>

using namespace std::chrono_literals;
using harvest_msgs::msg::Basket;
using harvest_msgs::msg::Fruit;
using F = Basket::Field;

int main() {
  auto node = sft::Node::open({.name = "own_message"});
  if (!node) return std::fprintf(stderr, "%s\n", node.error().message.c_str()), 1;
  // Both sides ask for reliability, and the last basket is kept for later subscribers.
  auto baskets =
      node->publisher<Basket>("basket", {.reliability = sft::reliable, .durability = sft::transient_local});
  if (!baskets) return std::fprintf(stderr, "%s\n", baskets.error().message.c_str()), 1;

  Basket basket;
  basket.name = "B-17";
  basket.fruits = {
      {.diameter_mm = 71.5F}, {.diameter_mm = 68}, {.ripeness = Fruit::UNRIPE, .diameter_mm = 40}};
  if (baskets->publish(basket) != sft::PublishStatus::ok) return 1;

  auto reader = node->subscriber<Basket, F::name | F::fruits.each.ripeness>(
      "basket", {.reliability = sft::reliable, .durability = sft::transient_local});
  if (!reader) return std::fprintf(stderr, "%s\n", reader.error().message.c_str()), 1;
  if (!reader->wait(5s)) return std::puts("no basket came"), 1;
  const auto sample = reader->take();
  const auto fruits = sample->fruits();  // a range that reads each element in place
  const auto ripe = std::ranges::count_if(fruits, [](const auto& f) { return f.ripeness() == Fruit::RIPE; });
  std::printf("basket %s: %td of %zu fruits are ripe\n", std::string(sample->name()).c_str(), ripe,
              fruits.size());
}
