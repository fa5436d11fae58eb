// Usage: check_figures FILE SAMPLES FULL_BYTES declared|recorded
// Checks what sft_demo --json has written of a run in which SAMPLES messages of FULL_BYTES bytes were
// published. Says what is wrong with it, and returns 1 then.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace {

using nlohmann::json;

// Link layer included: 14 of Ethernet, 20 of IP, 8 of UDP, 32 of SFT, 8 of fields, and some to spare.
constexpr double diagnostic_bytes_min = 60;
constexpr double diagnostic_bytes_max = 90;
constexpr double idle_bytes_per_s_max = 300;
constexpr double header_share_max = 0.06;  // of large messages: 58 bytes in 1514

int failures = 0;

void expect(bool condition, const std::string& what) {
  if (condition) return;
  std::fprintf(stderr, "wrong: %s\n", what.c_str());
  ++failures;
}

const json& subscriber(const json& run, const std::string& name) {
  for (const json& s : run.at("subscribers")) {
    if (s.at("name") == name) return s;
  }
  throw std::runtime_error("there is no subscriber " + name);
}

void check_common(const json& s, std::uint64_t samples, double full_bytes, const std::string& requirement) {
  const std::string name = s.at("name");
  expect(s.at("received") == samples, name + " received " + s.at("received").dump());
  expect(s.at("lost") == 0, name + " lost " + s.at("lost").dump());
  expect(s.at("full_bytes_per_sample") == full_bytes,
         name + ": full_bytes_per_sample " + s.at("full_bytes_per_sample").dump());
  expect(s.at("requirement") == requirement, name + ": requirement " + s.at("requirement").dump());
  expect(!s.at("reason").get<std::string>().empty(), name + ": no reason for its transport");
  const json& latency = s.at("latency_us");
  expect(latency.at("p50") > 0 && latency.at("p99") >= latency.at("p50"),
         name + ": latency_us " + latency.dump());
}

void check_roles(const json& run) {
  const json slam{"header", "width", "fields", "is_bigendian", "point_step", "row_step", "data", "is_dense"};
  expect(run.at("subscribers").size() == 4, "not four subscribers");
  expect(subscriber(run, "diagnostic").at("fields") == json({"height", "width"}), "fields of diagnostic");
  expect(subscriber(run, "detector").at("fields") == json({"data"}), "fields of detector");
  expect(subscriber(run, "slam").at("fields") == slam, "fields of slam");
  expect(subscriber(run, "viewer").at("fields").size() == slam.size() + 1, "fields of viewer");
  for (const char* remote : {"diagnostic", "detector", "slam"}) {
    expect(subscriber(run, remote).at("transport") == "udp", std::string(remote) + " is not served by UDP");
  }
  expect(subscriber(run, "viewer").at("transport") == "shm",
         "viewer is not served in shared memory: " + subscriber(run, "viewer").at("reason").dump());
}

void check_wire(const json& run, double full_bytes, bool recorded) {
  const double diagnostic = subscriber(run, "diagnostic").at("wire_bytes_per_sample");
  expect(diagnostic >= diagnostic_bytes_min && diagnostic <= diagnostic_bytes_max,
         "wire_bytes_per_sample of diagnostic: " + std::to_string(diagnostic));
  for (const char* large : {"detector", "slam"}) {
    const double wire = subscriber(run, large).at("wire_bytes_per_sample");
    expect(wire > 0.9 * full_bytes && wire < (1 + header_share_max) * full_bytes,
           std::string("wire_bytes_per_sample of ") + large + ": " + std::to_string(wire));
    const double learning = subscriber(run, large).at("learning_bytes");
    expect(recorded ? learning > full_bytes : learning == 0,
           std::string("learning_bytes of ") + large + ": " + std::to_string(learning));
  }
  expect(subscriber(run, "viewer").at("wire_bytes_per_sample") == 0, "something was sent to viewer");
  const double idle = run.at("idle_bytes_per_s");
  expect(idle > 0 && idle <= idle_bytes_per_s_max, "idle_bytes_per_s: " + std::to_string(idle));
}

void check(const json& run, std::uint64_t samples, double full_bytes, const std::string& requirement) {
  expect(run.at("samples") == samples, "samples: " + run.at("samples").dump());
  check_roles(run);
  for (const json& s : run.at("subscribers")) check_common(s, samples, full_bytes, requirement);
  if (run.at("hosts") == 4) {
    check_wire(run, full_bytes, requirement == "recorded");
  } else {
    expect(run.at("hosts") == 1, "hosts: " + run.at("hosts").dump());
    std::puts("There were no real hosts: bytes on the wire are not checked.");
  }
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 5)
    return std::fprintf(stderr, "usage: check_figures FILE SAMPLES FULL_BYTES declared|recorded\n"), 2;
  check(json::parse(std::ifstream(argv[1])), std::strtoull(argv[2], nullptr, 10),
        std::strtod(argv[3], nullptr), argv[4]);
  return failures == 0 ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s: %s\n", argv[1], error.what());
  return 1;
}
