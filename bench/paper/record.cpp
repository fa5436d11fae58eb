#include "bench/paper/record.h"

#include <algorithm>
#include <random>

namespace sft::bench::paper {

// std::seed_seq and std::mt19937_64 give the same numbers on every machine, but distributions of the
// standard do not.
FieldSet draw_fields(std::uint64_t seed, const Configuration& of, std::size_t repeat, std::size_t receiver) {
  std::seed_seq all{seed,
                    seed >> 32,
                    std::uint64_t{of.fields},
                    std::uint64_t{of.field_bytes},
                    std::uint64_t{of.receivers},
                    static_cast<std::uint64_t>(of.percent),
                    std::uint64_t{repeat},
                    std::uint64_t{receiver}};
  std::mt19937_64 numbers(all);
  FieldSet fields = 0;
  for (std::size_t i = 0; i < of.fields; ++i) {
    const auto percentile = static_cast<int>(numbers() % 100);
    if (percentile < of.percent) fields |= FieldSet{1} << i;
  }
  return fields;
}

std::size_t least_bytes(std::size_t cdr_bytes) {
  constexpr std::size_t frame_headers = 14 + 20 + 8;
  constexpr std::size_t frame_payload_max = 1500 - 20 - 8;
  const std::size_t frames =
      std::max<std::size_t>(1, (cdr_bytes + frame_payload_max - 1) / frame_payload_max);
  return cdr_bytes + frames * frame_headers;
}

std::string name_of(Way way) {
  constexpr const char* names[] = {"SFT, recorded", "SFT, declared", "SFT, all fields", "Cyclone DDS",
                                   "Fast DDS"};
  return names[static_cast<std::size_t>(way)];
}

std::string name_of(const Contender& contender) {
  return name_of(contender.way) + (contender.reliable ? ", reliable" : ", best effort") +
         (contender.multicast ? ", multicast" : ", unicast");
}

std::vector<Contender> all_contenders() {
  std::vector<Contender> all;
  for (const Way way : {Way::sft_recorded, Way::sft_declared, Way::sft_full, Way::cyclone, Way::fast_dds}) {
    for (const bool reliable : {false, true}) {
      for (const bool multicast : {false, true}) all.push_back({way, reliable, multicast});
    }
  }
  return all;
}

Contender idle_twin(const Contender& contender) {
  return {contender.is_sft() ? Way::sft_full : contender.way, false, contender.multicast};
}

}  // namespace sft::bench::paper
