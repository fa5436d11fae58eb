#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nav_msgs/msg/OccupancyGrid.hpp>
#include <sensor_msgs/msg/Image.hpp>

#include "bench/typesupport/messages.h"
#include "bench/typesupport/typesupport.h"

namespace sft::bench {

namespace {

using namespace detail;

namespace fs = std::filesystem;

Figure lines_per_field() {
  double lines = 0;
  double fields = 0;
  for (const auto& file : fs::recursive_directory_iterator(SFT_BENCH_GENERATED)) {
    if (file.path().extension() != ".hpp") continue;
    std::ifstream stream(file.path());
    for (std::string line; std::getline(stream, line);) {
      if (line.find_first_not_of(" \t") != std::string::npos) ++lines;
      if (line.find("sft::member<") != std::string::npos) ++fields;  // a row of a type's table
    }
  }
  return {"generated_lines_per_field", lines / fields, "", {}, "of all headers, blank lines aside", 40};
}

std::string replaced(std::string text, std::string_view what, std::string_view by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
    text.replace(at, what.size(), by);
  return text;
}

/// Returns the text of code that calls all getters below `view`.
std::string reads(const StructType& type, const std::string& view, int depth = 0) {
  std::string code;
  const std::string element = "e" + std::to_string(depth);
  for (const Member& m : type.members) {
    const std::string getter = view + "." + std::string(m.name) + "()";
    if (m.kind != Kind::structure) {
      code += "  use(" + getter + ");\n";
    } else if (m.shape == Shape::single) {
      code += reads(*m.type, getter, depth);
    } else {
      code +=
          "  for (auto " + element + " : " + getter + ") {\n" + reads(*m.type, element, depth + 1) + "  }\n";
    }
  }
  return code;
}

constexpr const char* headers = "#include <sft/sft.h>\n";

/// Returns the source of a program that publishes a message, and reads all fields of the messages that it
/// receives.
std::string program_with(const StructType& type) {
  const std::string name(type.name);
  return std::string(headers) + "#include <" + replaced(name, "::", "/") + ".hpp>\n" +  //
         "using T = ::" + name + ";\n" + R"(
template <class V>
void use(const V& v) { asm volatile("" : : "r"(&v) : "memory"); }

void publish(sft::Node& node, const T& message) {
  auto publisher = node.publisher<T>("topic").value();
  publisher.publish(message);
  std::move(publisher.loan(message).value()).publish();
}

void subscribe(sft::Node& node) {
  auto subscriber = node.subscriber<T, sft::all<T>>("topic").value();
  const auto sample = subscriber.take();
  use(sample.to_owned());
  const auto view = sample.view();
)" + reads(type, "view") +
         "}\n";
}

/// Returns the processor time of the compiler, which equals the waiting time on an idle core. Negative if
/// the compiler failed.
double compile_seconds(const fs::path& directory, const std::string& source) {
  const std::string from = directory / "program.cpp";
  const std::string to = directory / "program.o";
  std::ofstream(from) << source;
  const pid_t child = fork();
  if (child == 0) {
    execlp(SFT_BENCH_CXX, SFT_BENCH_CXX, "-std=c++20", "-O2", "-I" SFT_BENCH_RUNTIME, "-I" SFT_BENCH_CORE,
           "-isystem", SFT_BENCH_GENERATED, "-c", "-o", to.c_str(), from.c_str(), nullptr);
    _exit(127);
  }
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  const auto seconds = [](timeval t) {
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) / 1e6;
  };
  return status == 0 ? seconds(usage.ru_utime) + seconds(usage.ru_stime) : -1;
}

double best_compile_seconds(const std::string& source) {
  std::string directory = fs::temp_directory_path() / "bench_typesupport_XXXXXX";
  if (mkdtemp(directory.data()) == nullptr) return -1;
  const double best = std::min(compile_seconds(directory, source), compile_seconds(directory, source));
  fs::remove_all(directory);
  return best;
}

std::vector<Figure> compilation() {
  const std::array types{
      &TypeTable<sensor_msgs::msg::PointCloud2>::type,  &TypeTable<sensor_msgs::msg::LaserScan>::type,
      &TypeTable<sensor_msgs::msg::BatteryState>::type, &TypeTable<sensor_msgs::msg::Image>::type,
      &TypeTable<nav_msgs::msg::OccupancyGrid>::type,   &TypeTable<nav_msgs::msg::Odometry>::type};
  double total = 0;
  for (const StructType* type : types) {
    const double seconds = best_compile_seconds(program_with(*type));
    if (seconds < 0) return {};
    total += seconds;
  }
  const double each = total / static_cast<double>(types.size());
  const double empty = best_compile_seconds(headers);
  return {{"compile_seconds_per_message", each, "s", {}, "publishes, subscribes, reads all", 2},
          {"compile_seconds_of_sft_h", empty, "s", {}, "the same without a message", {}},
          {"compile_seconds_beyond_sft_h", each - empty, "s", {}, "the difference", {}}};
}

}  // namespace

std::vector<Figure> generated_code() {
  std::vector<Figure> figures = compilation();
  figures.insert(figures.begin(), lines_per_field());
  return figures;
}

}  // namespace sft::bench
