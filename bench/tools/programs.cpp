#include "bench/tools/programs.h"

#include <fcntl.h>
#include <sft/sft.h>
#include <unistd.h>
#include <chrono>
#include <fstream>
#include <iterator>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <utility>

#include "bench/common/node_options.h"
#include "bench/common/pair.h"
#include "bench/common/process.h"
#include "bench/selection/messages.h"
#include "tests/support/isolated_host.h"

namespace sft::bench {

pid_t start_program(int core, std::vector<std::string> words, const std::string& output) {
  return start_on_core(core, [&] {
    const int file = open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(file, STDOUT_FILENO);
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    execvp(pointers[0], pointers.data());
    return 127;
  });
}

pid_t start_sft(int core, std::vector<std::string> arguments, const std::string& output) {
  arguments.insert(arguments.begin(), test::program_directory() + "/sft");
  return start_program(core, std::move(arguments), output);
}

nlohmann::json last_json(const std::string& file) {
  std::ifstream in(file);
  std::string text{std::istreambuf_iterator(in), {}};
  if (!nlohmann::json::accept(text)) {
    while (text.ends_with('\n')) text.pop_back();
    text = text.substr(text.rfind('\n') + 1);
  }
  return nlohmann::json::accept(text) ? nlohmann::json::parse(text) : nlohmann::json();
}

int publish_clouds(const Clouds& clouds, Stage& stage) {
  using namespace std::chrono_literals;
  using sensor_msgs::msg::PointCloud2;
  constexpr std::int64_t retry_us = 100;
  constexpr std::int64_t last_us = 300'000;  // the time in which readers take the last samples

  Node node = Node::open(node_options("camera", TransportChoice::shm)).value();
  const bool is_flood = clouds.period_us == 0;
  auto publisher = node.publisher<PointCloud2>("cloud", {.reliability = is_flood ? reliable : best_effort,
                                                         .max_blocking = is_flood ? 1s : 0s})
                       .value();
  PointCloud2 prototype = ouster_cloud();
  prototype.height = clouds.rows;
  prototype.data.clear();
  if (!publisher.wait_for_subscribers(1, 20s)) return 1;
  const std::int64_t begin = now_ns();
  stage.begun_at = begin;
  for (std::uint64_t i = 0; i < clouds.count && !stage.over;) {
    if (!is_flood) sleep_until(begin + static_cast<std::int64_t>(i) * clouds.period_us * 1000);
    auto loan = publisher.loan_for_overwrite(prototype, {.data = clouds.rows * prototype.row_step});
    if (loan) std::move(*loan).publish();
    if (loan || !is_flood) ++i;
    if (!loan) sleep_us(retry_us);
  }
  sleep_us(last_us);
  return 0;
}

}  // namespace sft::bench
