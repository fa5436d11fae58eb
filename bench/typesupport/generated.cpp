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

/// Calls of all getters below `view`.
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

constexpr const char* runtime_includes =
    "#include <sft/typesupport/decode.h>\n#include <sft/typesupport/encode.h>\n"
    "#include <sft/typesupport/generated.h>\n";

/// A program's part that reads, encodes and decodes a message.
std::string user_of(const StructType& type) {
  const std::string name(type.name);
  return std::string(runtime_includes) + "#include <" + replaced(name, "::", "/") + ".hpp>\n" +
         "using T = ::" + name +
         ";\ntemplate <class V> void use(const V& v) { asm volatile(\"\" : : \"r\"(&v) : \"memory\"); }\n"
         "void read(const sft::SampleState& s) {\n  const auto view = sft::view_of<T, sft::all<T>>(s);\n" +
         reads(type, "view") +
         "}\nvoid record(const sft::SampleState& s) { use(sft::view_of<T, sft::recorded>(s)); }\n"
         "auto size(const T& v, const sft::FieldMask& m) {\n"
         "  return sft::encoded_size(sft::TypeTable<T>::type, &v, m);\n}\n"
         "auto decode(const sft::SampleState& s, T& v) {\n"
         "  return sft::decode(s, sft::TypeTable<T>::type, &v);\n}\n";
}

/// Processor time of the compiler: on an idle core what one waits for. Negative if it failed.
double compile_seconds(const std::string& source) {
  const fs::path file =
      fs::temp_directory_path() / ("bench_typesupport_" + std::to_string(getpid()) + ".cpp");
  std::ofstream(file) << source;
  const std::string include = std::string("-I") + SFT_BENCH_RUNTIME;
  const pid_t child = fork();
  if (child == 0) {
    execlp(SFT_BENCH_CXX, SFT_BENCH_CXX, "-std=c++20", "-O2", include.c_str(), "-isystem",
           SFT_BENCH_GENERATED, "-S", "-o", "/dev/null", file.c_str(), nullptr);
    _exit(127);
  }
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  fs::remove(file);
  if (status != 0) return -1;
  const auto seconds = [](timeval t) {
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) / 1e6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double best_compile_seconds(const std::string& source) {
  return std::min(compile_seconds(source), compile_seconds(source));
}

std::vector<Figure> compilation() {
  const std::array<const StructType*, 6> types{
      &TypeTable<sensor_msgs::msg::PointCloud2>::type,  &TypeTable<sensor_msgs::msg::LaserScan>::type,
      &TypeTable<sensor_msgs::msg::BatteryState>::type, &TypeTable<sensor_msgs::msg::Image>::type,
      &TypeTable<nav_msgs::msg::OccupancyGrid>::type,   &TypeTable<nav_msgs::msg::Odometry>::type};
  double total = 0;
  for (const StructType* type : types) {
    const double seconds = best_compile_seconds(user_of(*type));
    if (seconds < 0) return {};
    total += seconds;
  }
  const double each = total / static_cast<double>(types.size());
  const double empty = best_compile_seconds(runtime_includes);
  return {{"compile_seconds_per_message", each, "s", {}, "with the headers of the runtime", 2},
          {"compile_seconds_of_headers", empty, "s", {}, "the headers of the runtime alone", {}},
          {"compile_seconds_beyond_headers", each - empty, "s", {}, "the difference", {}}};
}

}  // namespace

std::vector<Figure> generated_code() {
  std::vector<Figure> figures = compilation();
  figures.insert(figures.begin(), lines_per_field());
  return figures;
}

}  // namespace sft::bench
