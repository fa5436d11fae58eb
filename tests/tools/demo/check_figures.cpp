// Usage: check_figures FILE SAMPLES FULL_BYTES declared|recorded Checks the file that sft_demo --json has
// written for a run in which SAMPLES messages of FULL_BYTES bytes were published. If a figure is wrong, the
// program prints it, and returns 1. A best-effort reader on a busy machine may lose samples, but must have
// counted the lost samples.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace {

using nlohmann::json;

// These limits allow for headers (Ethernet 14, IP 20, UDP 8, SFT 32), fields (8), and some bytes of
// tolerance. All sizes are in bytes.
constexpr double small_bytes_min = 60;
constexpr double scalar_bytes_max = 90;
constexpr double header_bytes_max = 130;           // larger, because `header` contains a name
constexpr double header_share_max = 0.06;          // the fraction of headers in the bytes of large messages:
                                                   // 58 of 1514 bytes
constexpr double localiser_share = 0.5 * 16 / 48;  // every second point, and 16 of the 48 bytes of each point

int failures = 0;

void expect(bool condition, const std::string& what) {
  if (condition) return;
  std::fprintf(stderr, "wrong: %s\n", what.c_str());
  ++failures;
}

const json& subscriber(const json& run, std::string_view name) {
  for (const json& s : run.at("subscribers")) {
    if (s.at("name") == name) return s;
  }
  throw std::runtime_error("there is no subscriber " + std::string(name));
}

void check_common(const json& s, std::uint64_t samples, double full_bytes, const std::string& requirement) {
  const std::string name = s.at("name");
  const std::uint64_t received = s.at("received");
  const std::uint64_t withheld = s.at("withheld");
  const std::uint64_t lost = s.at("lost");
  expect(received > 0 && received + withheld + lost == samples,
         name + " received " + s.at("received").dump() + ", withheld " + s.at("withheld").dump() + ", lost " +
             s.at("lost").dump());
  expect((withheld > 0) == (name == "localiser"), name + ": withheld " + s.at("withheld").dump());
  expect(s.at("full_bytes_per_sample") == full_bytes,
         name + ": full_bytes_per_sample " + s.at("full_bytes_per_sample").dump());
  expect(s.at("requirement") == requirement, name + ": requirement " + s.at("requirement").dump());
  expect(!s.at("reason").get<std::string>().empty(), name + ": no reason for its transport");
  const json& latency = s.at("latency_us");
  expect(latency.at("p50") > 0 && latency.at("p99") >= latency.at("p50"),
         name + ": latency_us " + latency.dump());
}

void check_roles(const json& run, bool recorded) {
  const std::vector<std::pair<std::string, json>> remote{
      {"health", {"header", "width"}},
      {"dashboard", {"height", "width", "is_dense"}},
      {"recorder", {"header.stamp"}},
      {"localiser", {"header", "data{intensity,x,y,z}[::2]"}},
  };
  expect(run.at("subscribers").size() == remote.size() + 1, "not five subscribers");
  for (const auto& [name, fields] : remote) {
    const json& s = subscriber(run, name);
    const bool still_learns = recorded && name == "localiser";  // the localiser has received too few clouds
    expect(still_learns || s.at("fields") == fields, name + " asks for " + s.at("fields").dump());
    expect(s.at("transport") == "udp", name + " is not served by UDP");
  }
  expect(subscriber(run, "detector").at("fields") == json({"data{x,y,z}"}),
         "fields of detector: " + subscriber(run, "detector").at("fields").dump());
  expect(subscriber(run, "detector").at("transport") == "shm",
         "detector is not served in shared memory: " + subscriber(run, "detector").at("reason").dump());
}

void check_wire(const json& run, double full_bytes, bool recorded) {
  for (const auto& [small, bytes_max] :
       {std::pair("health", header_bytes_max), std::pair("dashboard", scalar_bytes_max),
        std::pair("recorder", scalar_bytes_max)}) {
    const json& s = subscriber(run, small);
    const double wire = s.at("wire_bytes_per_sample");
    // While fields are recorded, a lost sample is a whole message, and parts of it may arrive later than
    // the next samples. The figure is the mean of the samples after those that were whole.
    const double late = recorded ? s.at("lost").get<double>() * (1 + header_share_max) * full_bytes : 0;
    const double learning = s.at("learning_bytes");
    const double selected = s.at("received").get<double>() - std::ceil(learning / full_bytes);
    expect(wire >= small_bytes_min && wire <= bytes_max + late / std::max(selected, 1.0),
           std::string("wire_bytes_per_sample of ") + small + ": " + std::to_string(wire));
    expect(recorded ? learning > full_bytes : learning == 0,
           std::string("learning_bytes of ") + small + ": " + std::to_string(learning));
  }
  const json localiser = subscriber(run, "localiser");
  const double large = localiser.at("wire_bytes_per_sample");
  const double part = recorded ? 1 : localiser_share;  // a localiser that records still receives whole clouds
  // The link also carried the bytes of the samples that were lost.
  const double carried = 1 + localiser.at("lost").get<double>() / localiser.at("received").get<double>();
  expect(large > 0.98 * part * full_bytes && large < (1 + header_share_max) * carried * part * full_bytes,
         "wire_bytes_per_sample of localiser: " + std::to_string(large));
  expect(subscriber(run, "detector").at("wire_bytes_per_sample") == 0, "something was sent to detector");
}

void check_total(const json& run, std::uint64_t samples, double full_bytes) {
  const double carried = run.at("carried_bytes");
  const double whole = run.at("whole_bytes");
  expect(std::abs(whole - 4 * static_cast<double>(samples) * full_bytes) < 1,
         "whole_bytes: " + std::to_string(whole));
  expect(carried > 0 && carried < whole / 2, "carried_bytes: " + std::to_string(carried));
}

void check(const json& run, std::uint64_t samples, double full_bytes, const std::string& requirement) {
  expect(run.at("samples") == samples, "samples: " + run.at("samples").dump());
  check_roles(run, requirement == "recorded");
  check_total(run, samples, full_bytes);
  for (const json& s : run.at("subscribers")) check_common(s, samples, full_bytes, requirement);
  if (run.at("hosts") == 5) {
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
