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

  void note(const Costs& costs, void (Tally::*add)(double)) {
    (bytes.*add)(costs.bytes);
    (publisher_cpu.*add)(costs.publisher_cpu_us);
    (subscriber_cpu.*add)(costs.subscriber_cpu_us);
    (settled.*add)(costs.settled_ms);
  }
};

/// The number of samples that are sent in 8.5 s. Cyclone DDS renews the leases of all nodes every 8 s, so
/// that a run of this length always includes a renewal, and a shorter run only by chance. Renewals matter
/// because the processor time of a node includes its control traffic. A node of SFT sends a heartbeat every
/// second.
constexpr std::uint64_t samples_of_a_period = 170;

constexpr const char* multicast = "Cyclone DDS, multicast";

}  // namespace

std::vector<Figure> masks_64(const ManyScale& scale) {
  const Case case_of_64{.readers = 64,
                        .hosts = emulated_hosts,
                        .topic = cloud_topic(data_bytes),
                        .fields = own_fields_and_data,
                        .settling_s = scale.quick ? 1.5 : 6.,
                        .samples = scale.quick ? std::uint64_t{30} : samples_of_a_period,
                        .period_us = 50'000};
  Tallies tallies;
  for (int round = 0; round < scale.rounds; ++round) {
    tallies.note(SampleCosts(sft_member, case_of_64).wait(), &Tally::add_ours);
    tallies.note(SampleCosts(cyclone_member, case_of_64).wait(), &Tally::add_reference);
  }
  return {tallies.bytes.figure("bytes_masks_64", "B", multicast, 1.05),
          tallies.settled.figure_with_bound_of_value("settled_ms", "ms", multicast, 100),
          tallies.publisher_cpu.figure("publisher_cpu_masks_64", "us", multicast, 1),
          tallies.subscriber_cpu.figure("subscriber_cpu_64", "us", multicast, 1.1)};
}

}  // namespace sft::bench
