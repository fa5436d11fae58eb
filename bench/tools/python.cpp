// Measures the Python package, compared with the same steps in C++.
#include <fmt/format.h>
#include <sft/sft.h>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <utility>

#include "bench/common/cloud.h"
#include "bench/common/node_options.h"
#include "bench/common/pair.h"
#include "bench/common/process.h"
#include "bench/common/shared.h"
#include "bench/common/statistics.h"
#include "bench/tools/programs.h"
#include "bench/tools/tools.h"
#include "tests/support/temporary_directory.h"

namespace sft::bench {

namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

constexpr double takes_more_us = 8;     // the limit of a take in Python minus a take in C++
constexpr double points_us = 30;        // the limit of the access to the points of a cloud of any size
constexpr double loan_bound = 1.1;      // the limit relative to a loan in C++
constexpr double private_bound = 0.01;  // the limit relative to the bytes of the samples that Python holds
constexpr std::int64_t period_us = 2000;
constexpr std::uint32_t rows = 128;  // a cloud with this number of rows has 6.3 MB

double us_since(std::int64_t begin) { return static_cast<double>(now_ns() - begin) / 1000; }

std::vector<double> take_in_cpp(std::uint64_t count) {
  Node node = Node::open(node_options("reader", TransportChoice::shm)).value();
  auto subscriber = node.subscriber<PointCloud2, F::height | F::width>("cloud").value();
  std::vector<double> times;
  while (times.size() < count && subscriber.wait(5s)) {
    const std::int64_t begin = now_ns();
    const auto sample = subscriber.take();
    if (!sample || sample->height() * sample->width() == 0) continue;
    times.push_back(us_since(begin));
  }
  return times;
}

std::vector<double> lend_in_cpp(std::uint64_t count) {
  Node node = Node::open(node_options("camera", TransportChoice::shm)).value();
  auto publisher = node.publisher<PointCloud2>("cloud").value();
  PointCloud2 prototype = cloud(sent_cloud_bytes);
  const std::vector<std::uint8_t> data = std::exchange(prototype.data, {});
  std::vector<double> times;
  if (!publisher.wait_for_subscribers(1, 20s)) return times;
  while (times.size() < count) {
    const std::int64_t begin = now_ns();
    auto loan = publisher.loan_for_overwrite(prototype, {.data = sent_cloud_bytes});
    if (!loan) return {};
    std::memcpy((*loan)->data().data(), data.data(), data.size());
    std::move(*loan).publish();
    times.push_back(us_since(begin));
    sleep_us(period_us);
  }
  return times;
}

/// Takes samples until the stage is over.
int take_all(const Stage& stage) {
  Node node = Node::open(node_options("reader", TransportChoice::shm)).value();
  auto subscriber = node.subscriber<PointCloud2, F::height | F::width>("cloud").value();
  while (!stage.over) {
    subscriber.wait(100ms);
    while (subscriber.take()) {
    }
  }
  return 0;
}

/// Runs the programs of one measurement: the measured program, and a program that publishes to it or reads
/// from it.
class Course {
 public:
  explicit Course(std::uint64_t count) : count_(count) {}

  /// Returns the results of a step in Python, or null if it failed.
  json in_python(const std::string& step, std::uint32_t cloud_rows) const {
    const auto start = [&] {
      return start_program(1,
                           {SFT_PYTHON, "-B", SFT_PYTHON_SIDE, step, std::to_string(count_),
                            std::to_string(cloud_rows * sent_cloud_bytes / rows)},
                           output_);
    };
    return beside(step == "loan", cloud_rows, start);
  }
  json in_cpp(std::vector<double> (*step)(std::uint64_t)) const {
    const auto start = [&] {
      return start_on_core(1, [&] {
        std::ofstream(output_) << json{{"times", step(count_)}};
        return 0;
      });
    };
    return beside(step == lend_in_cpp, rows, start);
  }

 private:
  template <class Start>
  json beside(bool publishes, std::uint32_t cloud_rows, const Start& start) const {
    const Shared<Stage> stage;
    const pid_t other = start_on_core(0, [&] {
      return publishes ? take_all(*stage)
                       : publish_clouds({.rows = cloud_rows, .period_us = period_us}, *stage);
    });
    const bool measured = succeeds(start());
    stage->over = true;
    succeeds(other);
    return measured ? last_json(output_) : json();
  }

  const std::uint64_t count_;
  const test::TemporaryDirectory folder_;
  const std::string output_ = folder_.path() / "times.json";
};

/// Adds the times with this name; no times if the step failed.
void add(Rounds& to, const json& result, const char* name = "times") {
  if (result.contains(name)) to.add(result[name].get<std::vector<double>>());
}

}  // namespace

std::vector<Figure> python(const Scale& scale) {
  if (!std::filesystem::exists(SFT_PYTHON_PACKAGE "/sft")) {
    fmt::print(stderr, "python is left out: there is no Python package; pybind11-dev is missing\n");
    return {};
  }
  setenv("PYTHONPATH", SFT_PYTHON_PACKAGE, 1);
  const Course course(static_cast<std::uint64_t>(scale.seconds * 1e6 / period_us / 2));
  Rounds take, take_cpp, points, points_small, columns, columns_small, loan, loan_cpp;
  std::vector<double> copied, grown, held;
  for (int round = 0; round < scale.rounds; ++round) {
    add(take, course.in_python("take", rows));
    add(take_cpp, course.in_cpp(take_in_cpp));
    const json large = course.in_python("points", rows);
    const json small = course.in_python("points", 1);
    add(points, large, "points");
    add(columns, large, "columns");
    add(points_small, small, "points");
    add(columns_small, small, "columns");
    const json lent = course.in_python("loan", rows);
    add(loan, lent);
    add(loan_cpp, course.in_cpp(lend_in_cpp));
    for (const json& one : {large, lent})
      if (one.contains("copied")) copied.push_back(one["copied"].get<double>());
    if (!large.contains("held")) continue;
    grown.push_back(large["grown"].get<double>() / 1e6);
    held.push_back(large["held"].get<double>() / 1e6);
  }
  const auto flat = [](const char* name, const Rounds& of, const Rounds& small) {
    return Figure{.name = name,
                  .value = of.p50(),
                  .unit = "us",
                  .reference = small.p50(),
                  .reference_name = "a cloud of 49 kB",
                  .bound = points_us,
                  .bound_is_of_value = true};
  };
  return {{"python_take", take.p50(), "us", take_cpp.p50(), "the same in C++", {}},
          {"python_take_more", take.p50() - take_cpp.p50(), "us", {}, "", takes_more_us},
          flat("python_points", points, points_small),
          flat("python_columns", columns, columns_small),
          {"python_publish_loan", loan.p50(), "us", loan_cpp.p50(), "the same in C++", loan_bound},
          {"python_bytes_copied", median_if_any(copied), "B", {}, "", 0},
          {"python_private_memory", median_if_any(grown), "MB", median_if_any(held),
           "samples that Python holds", private_bound}};
}

}  // namespace sft::bench
