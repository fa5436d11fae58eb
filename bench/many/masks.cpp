// Measures the costs of readers with different masks.
#include "bench/common/cloud_masks.h"
#include "bench/many/many.h"
#include "bench/many/sample_costs.h"
#include "bench/many/tally.h"

namespace sft::bench {

namespace {

constexpr std::size_t data_bytes = 16'000;

struct Tallies {
  Tally bytes, publisher_cpu, subscriber_cpu, settled;

  /// Runs both contenders at the same time. That is possible because it does not influence the number of
  /// bytes.
  void run_for_bytes(const Case& of, int rounds) {
    for (int round = 0; round < rounds; ++round) {
      SampleCosts ours(sft_member, of);
      SampleCosts theirs(cyclone_member, of);
      note(ours.wait().front(), &Tally::add_ours);
      note(theirs.wait().front(), &Tally::add_reference);
    }
  }

  void note(const Costs& costs, void (Tally::*add)(double)) {
    (bytes.*add)(costs.bytes);
    (publisher_cpu.*add)(costs.publisher_cpu_us);
    (subscriber_cpu.*add)(costs.subscriber_cpu_us);
    (settled.*add)(costs.settled_ms);
  }
};

Case many_masks(std::size_t readers, const ManyScale& scale, std::uint64_t samples) {
  return {.readers = readers,
          .hosts = emulated_hosts,
          .topic = cloud_topic(data_bytes),
          .phases = {own_fields_and_data},
          .settling_s = scale.quick ? 1.5 : 6.,
          .samples = scale.quick ? std::uint64_t{30} : samples,
          .period_us = 50'000};
}

/// The number of samples that are sent in 8.5 s. Cyclone DDS renews the leases of all nodes every 8 s, so
/// that a run of this length always includes a renewal, and a shorter run only by chance. Renewals matter
/// because the processor time of a node includes its control traffic. A node of SFT sends a heartbeat every
/// second.
constexpr std::uint64_t samples_of_a_period = 170;

/// Returns the fields that a map, a display and a monitor may need. Two of them need the data. All of them
/// together need nearly the whole cloud.
std::string fields_of_three(std::size_t number) {
  const char* fields[] = {"header, fields, point_step, data", "header.stamp, height, width, row_step, data",
                          "height, width"};
  return fields[number];
}

constexpr const char* multicast = "Cyclone DDS, multicast";
constexpr const char* raw_multicast = "raw UDP, multicast";
constexpr Member raw_member{"raw UDP", raw_multicast_peer};

}  // namespace

std::vector<Figure> masks_16(const ManyScale& scale) {
  Tallies tallies;
  tallies.run_for_bytes(many_masks(16, scale, 100), scale.rounds);
  return {tallies.bytes.figure("bytes_masks_16", "B", multicast, 1.05)};
}

std::vector<Figure> masks_64(const ManyScale& scale) {
  const Case case_of_64 = many_masks(64, scale, samples_of_a_period);
  Tallies tallies, floor;
  for (int round = 0; round < scale.rounds; ++round) {
    const Costs ours = SampleCosts(sft_member, case_of_64).wait().front();
    tallies.note(ours, &Tally::add_ours);
    floor.note(ours, &Tally::add_ours);
    tallies.note(SampleCosts(cyclone_member, case_of_64).wait().front(), &Tally::add_reference);
    floor.note(SampleCosts(raw_member, case_of_64).wait().front(), &Tally::add_reference);
  }
  return {tallies.bytes.figure("bytes_masks_64", "B", multicast, 1.05),
          tallies.settled.figure_with_bound_of_value("settled_ms", "ms", multicast, 100),
          tallies.publisher_cpu.figure("publisher_cpu_masks_64", "us", multicast, 1),
          tallies.subscriber_cpu.figure("subscriber_cpu_64", "us", multicast, 1.1),
          floor.publisher_cpu.figure("publisher_cpu_masks_64_vs_raw_udp", "us", raw_multicast, {}),
          floor.subscriber_cpu.figure("subscriber_cpu_64_vs_raw_udp", "us", raw_multicast, {})};
}

std::vector<Figure> three_masks(const ManyScale& scale) {
  Tallies tallies;
  const Case three{.readers = 3,
                   .hosts = 3,
                   .topic = cloud_topic(data_bytes),
                   .phases = {fields_of_three},
                   .settling_s = 0,
                   .samples = scale.quick ? std::uint64_t{20} : 100,
                   .period_us = 100'000};
  tallies.run_for_bytes(three, scale.rounds);
  return {tallies.bytes.figure("bytes_paper_three", "B", multicast, 1.02)};
}

}  // namespace sft::bench
